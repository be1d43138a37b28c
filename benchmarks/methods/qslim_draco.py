"""QSlim, then Draco: what people use. Faces and bits are chosen for each number of bytes."""

from . import drc, search
from .case import Case, Coded

NAME = "QSlim + Draco"


def at_bytes(case: Case, budgets: tuple[int, ...]) -> list[Coded | None]:
    """The best of all numbers of faces and bits."""
    return search.choose(case, drc.decode, drc.of_qslim(case, budgets))
