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
    """A stream for each budget; one whose base is the whole input, sent with all features, serves all larger ones too."""
    out: list[Coded | None] = []
    for budget in budgets:
        if not (out and out[-1] and out[-1].label.endswith("everything")):
            try:
                found = made(case, budget)
            except SettingsError:
                out.append(None)
                continue
            report, progressive = found.report, open_stream(found.data)
            label = f"{report.base_faces} faces, {report.levels} levels"
            if report.base_faces == len(case.mesh.F) and report.bytes < 0.98 * budget:
                label += ", everything"
            coded = Coded(progressive.decode(), report.bytes, label)
        out.append(coded)
    return out
