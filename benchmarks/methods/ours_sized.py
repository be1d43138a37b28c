"""Our codec with a size: for each budget a stream that is made for it, its base and levels chosen by the budget."""

from dataclasses import replace

from npm_blender.core.codec import Compressed, compress, open_stream
from npm_blender.core.errors import SettingsError

from .case import Case, Coded

NAME = "ours, made for the size"


def made(case: Case, budget: int) -> Compressed:
    """The stream for a budget. Raises SettingsError where no base mesh is so small."""
    return compress(case.mesh, replace(case.settings, budget=budget))


def at_bytes(case: Case, budgets: tuple[int, ...]) -> list[Coded | None]:
    """A stream for each budget, ascending; one that is the same for the next budget serves all larger ones too."""
    out: list[Coded | None] = []
    before, final = b"", False
    for budget in budgets:
        if final:
            out.append(out[-1])
            continue
        try:
            found = made(case, budget)
        except SettingsError:
            out.append(None)
            continue
        final, before = found.data == before, found.data
        report = found.report
        label = f"{report.base_faces} faces, {report.levels} levels"
        out.append(Coded(open_stream(found.data).decode(), report.bytes, label))
    return out
