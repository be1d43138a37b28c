"""Points spread uniformly over a mesh: stratified sampling of the faces by area."""
import numpy as np

from ..errors import MeshError
from ..mesh import TriMesh


def sample(mesh: TriMesh, count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Points uniform by area: points (count, 3) float64 in the mesh's frame, face (count,) int32 ascending.

    The faces lie one after the other on a line, each as long as its area; the line is cut into `count` equal pieces, and a
    random place in each names a face (stratified sampling, called jittered by Cook 1986). So a face gets as many points as
    its area asks for, less than two more or fewer, and the variance is smaller than that of independent points. In its
    triangle A, B, C a point is (1 - sqrt u) A + sqrt u (1 - v) B + sqrt u v C, with u and v uniform in 0..1 (Osada et al.
    2002). The same seed gives the same points. Raises MeshError if the mesh has no area.

    >>> from npm_blender.core import TriMesh
    >>> from npm_blender.core.geometry import sample
    >>> mesh = TriMesh.from_arrays([[0, 0, 0], [2, 0, 0], [0, 1, 0], [-6, 0, 0]], [[0, 1, 2], [0, 2, 3]])  # areas 1 and 3
    >>> points, face = sample(mesh, 8)
    >>> face.tolist(), points.shape
    ([0, 0, 1, 1, 1, 1, 1, 1], (8, 3))
    """
    total = np.cumsum(mesh.face_areas())
    if not total[-1] > 0:
        raise MeshError("Expected a surface with area, found only faces of zero area; check the mesh's scale")
    random = np.random.default_rng(seed)
    at = (np.arange(count) + random.random(count)) * (total[-1] / count)
    face = np.minimum(np.searchsorted(total, at, side="right"), np.searchsorted(total, total[-1])).astype(np.int32)
    u, v = random.random((2, count, 1))
    u = np.sqrt(u)
    a, b, c = mesh.V[mesh.F[face]].swapaxes(0, 1)
    return (1 - u) * a + u * (1 - v) * b + u * v * c, face
