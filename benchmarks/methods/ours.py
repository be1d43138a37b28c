"""Our codec: one displaced stream, made with the default settings; a budget or a count of numbers is a prefix of it."""

from npm_blender.core.mesh import TriMesh

from . import prefixes
from .case import Case, Coded

NAME = "ours"


def at_bytes(case: Case, budgets: tuple[int, ...]) -> list[Coded | None]:
    """The numbers that a prefix of so many bytes holds, finest level."""
    return prefixes.cut(prefixes.opened(case, case.settings), budgets, "numbers")


def at_scalars(case: Case, counts: list[int]) -> list[TriMesh | None]:
    """The numbers that come after three for each vertex of the base; None where the base alone has more, or all have fewer."""
    return prefixes.of_numbers(prefixes.opened(case, case.settings), counts)
