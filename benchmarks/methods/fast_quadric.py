"""A second line of quadric decimation: fast-simplification, which is fast and neither sorts its edges nor checks links."""

import fast_simplification
import numpy as np

from npm_blender.core.mesh import TriMesh

from .case import Case

NAME = "fast-simplification"
TRIES = 3


def _simplified(mesh: TriMesh, faces: int) -> TriMesh:
    if faces >= len(mesh.F):
        return mesh
    V, F = fast_simplification.simplify(mesh.V.astype(np.float32), mesh.F, target_count=faces)
    return TriMesh.from_arrays(V, F)


def at_scalars(case: Case, counts: list[int]) -> list[TriMesh | None]:
    """Three numbers a vertex; None where it stops above the count."""
    out = []
    for count in counts:
        best, faces = None, 2 * (count // 3)
        for _ in range(TRIES):
            mesh = _simplified(case.mesh, faces)
            left = count // 3 - len(mesh.V)
            if left >= 0:
                best = mesh
                break
            faces += 2 * left
            if faces < 4:
                break
        out.append(best)
    return out
