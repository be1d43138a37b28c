"""QSlim (libigl) of a split at 400 faces and at the compression ratios of our 40 and 400 features.

    python -m benchmarks.qslim CORPUS [--split test] [--samples N]

At equal ratio: our stream with k features holds 3 |V0| + 8 k numbers, so QSlim may keep |V0| + 8 k / 3 vertices.
"""

import argparse
from functools import partial
from pathlib import Path

import igl
import numpy as np

from npm_blender.core.mesh import TriMesh
from npm_blender.core.metrics import Original

from . import jobs
from .corpus import Entry, entries

BASE_FACES, DIM = 400, 8


def qslim(mesh: TriMesh, faces: int) -> TriMesh:
    """libigl's qslim down to a number of faces."""
    if faces >= len(mesh.F):
        return mesh
    V, F, *_ = igl.qslim(np.asfortranarray(mesh.V), np.asfortranarray(mesh.F), faces)
    return TriMesh.from_arrays(V, F)


def faces_at(features: int) -> int:
    """Faces that QSlim may keep for the numbers that we spend on 400 base faces and so many features."""
    vertices = BASE_FACES / 2 + 2
    return int(round(BASE_FACES * (3 * vertices + DIM * features) / (3 * vertices)))


def measure(entry: Entry, samples: int) -> dict:
    """Rows of one mesh."""
    mesh = entry.read()
    original = Original(mesh, samples)
    rows = []
    for features in (0, 40, 400):
        m = original.evaluate(qslim(mesh, faces_at(features)))
        rows.append(
            {
                "features": features,
                "faces": faces_at(features),
                "d_pm": m.d_pm,
                "d_normal": m.d_normal,
                "d_reverse": m.d_reverse,
            }
        )
    return {"rows": rows}


def main() -> None:
    """Read the options and run."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("corpus", type=Path)
    parser.add_argument("--split", default="test")
    parser.add_argument("--samples", type=int, default=200_000)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--limit", type=int)
    o = parser.parse_args()
    jobs.run(
        partial(measure, samples=o.samples),
        entries(o.corpus, o.split)[: o.limit],
        Path("out/quality") / f"qslim_{o.split}.jsonl",
        o.processes,
    )


if __name__ == "__main__":
    main()
