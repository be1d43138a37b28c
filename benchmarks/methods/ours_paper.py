"""The paper's model in our codec: one stream of latents on a base of 400 faces; what its tables 2 and 3 are made with."""

from dataclasses import replace

from npm_blender.core.codec import ProgressiveMesh
from npm_blender.core.evaluation import compression_ratio
from npm_blender.core.mesh import TriMesh
from npm_blender.core.settings import PAPER

from . import prefixes
from .case import FEATURES, Case, Coded

NAME = "ours, the paper's model"


def stream(case: Case) -> ProgressiveMesh:
    """The stream, opened."""
    return prefixes.opened(case, replace(case.settings, model=PAPER))


def at_bytes(case: Case, budgets: tuple[int, ...]) -> list[Coded | None]:
    """The latents that a prefix of so many bytes holds, finest level."""
    return prefixes.cut(stream(case), budgets, "latents")


def at_scalars(case: Case, counts: list[int]) -> list[TriMesh | None]:
    """As many latents as have so few numbers, 8 each, after those of the base mesh; None where there are not so many."""
    return prefixes.of_numbers(stream(case), counts)


def extra(case: Case) -> list[tuple[dict, TriMesh]]:
    """The rows of the paper's tables 2 and 3: by latents, and by level with 400 and with all of them."""
    progressive, out = stream(case), []

    def row(table: str, at, k: int, level: int) -> tuple[dict, TriMesh]:
        about = {"table": table, "at": at, "features": k, "level": level, "bytes": progressive.bytes_for(k)}
        about["cr"] = compression_ratio(len(case.mesh.V), progressive.base_vertices, progressive.numbers(k))
        return about, progressive.decode(k, level)

    counts = {k: min(k, progressive.features) for k in FEATURES} | {"all": progressive.features}
    out += [row("features", name, k, progressive.levels) for name, k in counts.items()]
    for name in (FEATURES[-1], "all"):
        out += [row(f"levels, {name}", level, counts[name], level) for level in range(1, progressive.levels)]
    return out
