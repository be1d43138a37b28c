"""Points spread uniformly over a mesh."""
import numpy as np

from ..errors import MeshError
from ..mesh import TriMesh


def sample(mesh: TriMesh, count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Points uniform by area: points (count, 3) float64 in the mesh's frame, face (count,) int32 ascending.

    One point in each of `count` equal shares of the area, in face order (systematic sampling: each point is uniform
    over the surface, with less variance than independent ones). The same seed gives the same points. Raises MeshError
    if the mesh has no area.
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
