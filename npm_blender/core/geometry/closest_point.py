"""The surface of a mesh: exact closest points, and points spread uniformly over it."""
import numpy as np

from ..errors import MeshError
from ..mesh.triangle_mesh import TriMesh
from . import bvh

GRID = 1024  # cells per axis of the curve along which queries are answered


class Surface:
    """The surface of a mesh, ready for closest-point queries. Faces without area count as the segments they are.

    Building takes about 0.1 s for 100k faces; queries run on one thread and release the GIL. Ties between faces that
    share the closest point go to one of them, the same on every run.
    """

    def __init__(self, mesh: TriMesh) -> None:
        """mesh: any TriMesh with at least one face; it need not be a manifold. Its arrays are copied."""
        corners = mesh.V[mesh.F].reshape(-1, 9)
        self._boxes, self._links, self._order = bvh.build(corners)
        self._corners = corners[self._order]

    def closest(self, P: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Closest points on the surface to P (n, 3) float64, in the mesh's frame.

        Returns distance (n,) float64, point (n, 3) float64 and face (n,) int32. Raises MeshError if P is not finite
        or not (n, 3).
        """
        P = np.ascontiguousarray(P, dtype=np.float64)
        if P.ndim != 2 or P.shape[1] != 3 or not np.isfinite(P).all():
            raise MeshError(f"Expected finite points (n, 3), found {P.shape}{'' if P.ndim != 2 else ' or NaN'}")
        distance, point, row = bvh.closest(P, _along_curve(P), self._corners, self._boxes, self._links)
        return distance, point, self._order[row]


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


def _along_curve(P: np.ndarray) -> np.ndarray:
    """Order of P (n, 3) along a Z-order curve of its bounding box, (n,) int64."""
    if len(P) == 0:
        return np.zeros(0, np.int64)
    low = P.min(0)
    size = max(float((P.max(0) - low).max()), 1e-300)
    cell = np.minimum((P - low) * (GRID / size), GRID - 1).astype(np.uint32)
    for shift, mask in ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249)):
        cell = (cell | (cell << np.uint32(shift))) & np.uint32(mask)
    return np.argsort(cell[:, 0] | (cell[:, 1] << np.uint32(1)) | (cell[:, 2] << np.uint32(2)), kind="stable")
