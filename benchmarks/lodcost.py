"""What the LoD builder costs beside libigl's qslim on the same meshes, in one run.

    python -m benchmarks.lodcost CORPUS

Wall-clock seconds, medians of three. The builder decimates to 400 faces and maps three levels on every core; qslim only
decimates, on one: as it comes, and refusing collapses that would make the surface pass through itself
(`block_intersections`).
"""
import argparse
import resource
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import igl
import numpy as np

from corpus.meshes import entries
from npm_blender.core.cleaning import clean
from npm_blender.core.decimation import decimate
from npm_blender.core.levels import build_levels
from npm_blender.core.mesh import TriMesh, UnitFrame, in_morton_order
from npm_blender.core.parallel import threads
from tests.meshes.shapes import bumpy, torus

BASE_FACES, LEVELS, REPEATS = 400, 3, 3
SMALL, LARGE = 6, 8  # subdivisions of the sphere with bumps: 81,920 and 1,310,720 faces
HUNDRED_THOUSAND, MILLION = (317, 158), (1000, 500)  # rows and columns of tori: 100,172 and 1,000,000 faces
CORPUS_FACES = (90_000, 120_000)


def seconds(work: Callable[[], object], repeats: int) -> tuple[float, object]:
    """Median seconds of wall clock, and the last result."""
    took = []
    for _ in range(repeats):
        begun = time.perf_counter()
        result = work()
        took.append(time.perf_counter() - begun)
    return float(np.median(took)), result


def measured(mesh: TriMesh, repeats: int) -> dict[str, float]:
    """Seconds of each step and of both ways of qslim, for a mesh in the unit frame; and this process's peak memory in MB."""
    one, decimation = seconds(lambda: decimate(in_morton_order(mesh), BASE_FACES), repeats)
    two, _ = seconds(lambda: build_levels(decimation, LEVELS), repeats)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    V, F = np.asfortranarray(mesh.V), np.asfortranarray(mesh.F)
    plain, _ = seconds(lambda: igl.qslim(V, F, BASE_FACES), repeats)
    blocked, (_, left, *_) = seconds(lambda: igl.qslim(V, F, BASE_FACES, True), repeats)
    return {"faces": len(mesh.F), "decimate": one, "levels": two, "qslim": plain, "blocked": blocked, "left": len(left),
            "memory": peak}


def meshes(corpus: Path) -> Iterator[tuple[str, TriMesh, int]]:
    """Names, meshes in the unit frame, and how often each is measured."""
    for entry in [e for split in ("val", "test") for e in entries(corpus, split)]:
        if CORPUS_FACES[0] <= entry.faces <= CORPUS_FACES[1]:
            yield entry.name, clean(entry.read(), "auto")[0], REPEATS
    yield "sphere with bumps", bumpy(SMALL), REPEATS
    yield "sphere with bumps", bumpy(LARGE), 1
    yield "torus with waves", torus(*HUNDRED_THOUSAND), REPEATS
    yield "torus with waves", torus(*MILLION), REPEATS


def table(corpus: Path) -> list[str]:
    """Lines of the table, and what it comes to."""
    build_levels(decimate(bumpy(3), 100), 1)
    lines = ["| mesh | faces | decimate, s | levels, s | qslim, s | ratio | blocking qslim, s | ratio |",
             "|---|---|---|---|---|---|---|---|"]
    rows = []
    for name, mesh, repeats in meshes(corpus):
        row = measured(TriMesh(UnitFrame.of(mesh.V).to_unit(mesh.V), mesh.F), repeats)
        ours = row["decimate"] + row["levels"]
        row |= {"total": ours, "to plain": ours / row["qslim"], "to blocked": ours / row["blocked"]}
        stuck = f" (ends at {row['left']:,} faces)" if row["left"] > BASE_FACES else ""
        lines.append(f"| {name} | {row['faces']:,} | {row['decimate']:.2f} | {row['levels']:.2f} | {row['qslim']:.2f} | "
                     f"{row['to plain']:.2f} | {row['blocked']:.2f}{stuck} | {row['to blocked']:.2f} |")
        rows.append(row)
    *hundred, sphere, larger, small, million = rows
    plain, blocked = (np.median([row[k] for row in [*hundred, sphere]]) for k in ("to plain", "to blocked"))
    growth = ", ".join(f"{b['faces']:,} faces take {b['total'] / a['total']:.1f} times as long as {a['faces']:,}"
                       for a, b in ((small, million), (sphere, larger)))
    return [*lines, "",
            f"On {threads()} threads. Medians over the meshes of the corpus and the smaller sphere: {plain:.3f} of qslim's "
            f"time, {blocked:.3f} of blocking qslim's. {growth}, and {larger['memory']:.0f} MB in all."]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("corpus", type=Path)
    print("\n".join(table(parser.parse_args().corpus)))


if __name__ == "__main__":
    main()
