"""Normals of a triangle mesh, in one pass over its faces."""
import numpy as np

from ..jit import compiled
from ..mesh import TriMesh
from ..parallel import each

SLICE = 26_000  # faces that one thread looks at


@compiled
def triangle_normal(P, a, b, c):
    """Normal (x, y, z) of the triangle of points a, b, c of P (n, 3): (P_b - P_a) x (P_c - P_a), twice as long as its area.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import triangle_normal
    >>> triangle_normal(np.array([[0.0, 0, 0], [2, 0, 0], [0, 3, 0]]), 0, 1, 2)
    (0.0, 0.0, 6.0)
    """
    ux, uy, uz = P[b, 0] - P[a, 0], P[b, 1] - P[a, 1], P[b, 2] - P[a, 2]
    vx, vy, vz = P[c, 0] - P[a, 0], P[c, 1] - P[a, 1], P[c, 2] - P[a, 2]
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


@compiled
def _normalize(N):
    for i in range(len(N)):
        size = max(np.sqrt(N[i, 0] * N[i, 0] + N[i, 1] * N[i, 1] + N[i, 2] * N[i, 2]), 1e-300)
        for c in range(3):
            N[i, c] /= size


@compiled
def _of_vertices(V, F, N):
    for f in range(len(F)):
        x, y, z = triangle_normal(V, F[f, 0], F[f, 1], F[f, 2])
        for c in range(3):
            v = F[f, c]
            N[v, 0] += x
            N[v, 1] += y
            N[v, 2] += z
    _normalize(N)


@compiled
def _of_faces(V, F, faces, N):
    for k in range(len(faces)):
        f = faces[k]
        N[k, 0], N[k, 1], N[k, 2] = triangle_normal(V, F[f, 0], F[f, 1], F[f, 2])
    _normalize(N)


def vertex_normals(mesh: TriMesh) -> np.ndarray:
    """Unit vertex normals (n, 3) float64, area-weighted: the sum of (P_b - P_a) x (P_c - P_a) over the faces of a vertex, brought
    to length one. Zero where the faces of a vertex cancel out.

    >>> from npm_blender.core import TriMesh
    >>> from npm_blender.core.geometry import vertex_normals
    >>> roof = TriMesh.from_arrays([[0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, 0, -1]], [[0, 1, 2], [1, 0, 3]])
    >>> vertex_normals(roof).round(3).tolist()
    [[-0.707, 0.0, 0.707], [-0.707, 0.0, 0.707], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]
    """
    N = np.zeros((len(mesh.V), 3))
    _of_vertices(mesh.V, mesh.F, N)
    return N


def normals_of(mesh: TriMesh, faces: np.ndarray) -> np.ndarray:
    """Unit normals (k, 3) float64 of the faces (k,), numbers of rows of mesh.F; zero for faces without area.

    >>> import numpy as np
    >>> from npm_blender.core import TriMesh
    >>> from npm_blender.core.geometry import normals_of
    >>> mesh = TriMesh.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2], [0, 2, 3]])
    >>> normals_of(mesh, np.array([1, 0, 1])).tolist()
    [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]
    """
    N = np.empty((len(faces), 3))

    def task(first: int) -> None:
        now = slice(first, first + SLICE)
        _of_faces(mesh.V, mesh.F, faces[now], N[now])

    each(task, range(0, len(faces), SLICE))
    return N
