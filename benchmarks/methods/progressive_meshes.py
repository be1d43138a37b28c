"""Progressive Meshes (Hoppe 1996): one stream of a base mesh and coded vertex splits, cut for each budget.

Numbers (at_scalars): three per base vertex (400 faces, as ours) and six per split, the places of both vertices that
come out of it; Neural Progressive Meshes counts no connectivity for any method, and for this one does not say more.
"""

import numpy as np

from benchmarks.progressive_meshes.simplify import simplify
from benchmarks.progressive_meshes.stream import decode, encode
from npm_blender.core.errors import StreamError
from npm_blender.core.mesh import TriMesh

from .case import Case, Coded

NAME = "Progressive Meshes"
BASE_FACES = 200  # of the stream: small, so that little is sent before the first split
SCALAR_FACES = 400


def at_bytes(case: Case, budgets: tuple[int, ...]) -> list[Coded | None]:
    """The stream, cut."""
    data = case.once("progressive meshes", lambda: encode(simplify(case.mesh, BASE_FACES))).data
    return [_decoded(data[:budget]) for budget in budgets]


def _decoded(data: bytes) -> Coded | None:
    try:
        return Coded(decode(data), len(data), "cut")
    except StreamError:  # shorter than the base mesh
        return None


def at_scalars(case: Case, counts: list[int]) -> list[TriMesh | None]:
    """The mesh after so many splits of a base of 400 faces, its places not quantized."""
    least = simplify(case.mesh, SCALAR_FACES)
    vertices = len(least.X) - len(least.ends)
    out: list[TriMesh | None] = []
    for count in counts:
        splits = (count - 3 * vertices) // 6
        if splits < 0:
            out.append(None)
            continue
        c = simplify(case.mesh, min(len(least.F) + 2 * splits, len(case.mesh.F)))
        used, F = np.unique(c.F, return_inverse=True)
        out.append(TriMesh.from_arrays(c.X[used], F.reshape(-1, 3)))
    return out
