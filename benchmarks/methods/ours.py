"""Our codec: one stream, made with the default settings; a budget or a number of features is a prefix of it."""

import numpy as np

from npm_blender.core.codec import ProgressiveMesh, compress, open_stream
from npm_blender.core.evaluation import compression_ratio
from npm_blender.core.mesh import TriMesh
from npm_blender.core.network import FEATURES

from .case import FEATURES as POINTS
from .case import Case, Coded

NAME = "ours"


def stream(case: Case) -> ProgressiveMesh:
    """The stream, opened; the seconds of its making go to case.seconds."""

    def make() -> ProgressiveMesh:
        made = compress(case.mesh, case.settings)
        case.seconds.update(made.report.seconds)
        return open_stream(made.data)

    return case.once("ours", make)


def at_bytes(case: Case, budgets: tuple[int, ...]) -> list[Coded | None]:
    """The features that a prefix of so many bytes holds, finest level."""
    progressive, out = stream(case), []
    for budget in budgets:
        if budget < progressive.base_bytes:
            out.append(None)
            continue
        k = progressive.features_for(min(budget, progressive.total_bytes))
        out.append(Coded(progressive.decode(k), progressive.bytes_for(k), f"{k} features"))
    return out


def at_scalars(case: Case, counts: list[int]) -> list[TriMesh | None]:
    """As many features as have so few numbers, after those of the base mesh; None where the stream has not so many."""
    progressive, out = stream(case), []
    numbers = np.array([3 * progressive.base_vertices + progressive.numbers(k) for k in range(progressive.features + 1)])
    for count in counts:
        k = int(np.searchsorted(numbers, count, side="right")) - 1
        out.append(progressive.decode(k) if k >= 0 and count - numbers[k] < FEATURES else None)
    return out


def extra(case: Case) -> list[tuple[dict, TriMesh]]:
    """The rows of the paper's tables 2 and 3: by features, and by level with 400 and with all of them."""
    progressive, out = stream(case), []

    def row(table: str, at, k: int, level: int) -> tuple[dict, TriMesh]:
        about = {"table": table, "at": at, "features": k, "level": level, "bytes": progressive.bytes_for(k)}
        about["cr"] = compression_ratio(len(case.mesh.V), progressive.base_vertices, progressive.numbers(k))
        return about, progressive.decode(k, level)

    counts = {k: min(k, progressive.features) for k in POINTS} | {"all": progressive.features}
    out += [row("features", name, k, progressive.levels) for name, k in counts.items()]
    for name in (POINTS[-1], "all"):
        out += [row(f"levels, {name}", level, counts[name], level) for level in range(1, progressive.levels)]
    return out
