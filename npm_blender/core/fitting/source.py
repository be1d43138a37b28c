"""The surface that is fitted, and points of it."""
import numpy as np

from ..geometry import ClosestPoints, sample
from ..mesh import TriMesh
from ..parallel import each

SAMPLES = 200_000
PIECE = 16_384  # points that one thread looks up at a time


class Source:
    """points (k, 3) float64 of the surface, spread evenly by area, its unit normals (k, 3) there, and their places in a random
    order, rank (k,) int64; unit frame.

    >>> import numpy as np
    >>> from npm_blender.core import TriMesh
    >>> from npm_blender.core.fitting import Source
    >>> square = TriMesh.from_arrays([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> distance, away = Source(square, 100).closest(np.array([[0.5, 0.5, 0.2]]))
    >>> distance.tolist(), away.tolist()
    ([0.2], [[0.0, 0.0, 1.0]])
    """

    def __init__(self, mesh: TriMesh, samples: int = SAMPLES) -> None:
        """mesh: in the unit frame. Raises MeshError if it has no area."""
        self.surface, self.face_normals = ClosestPoints(mesh), mesh.face_normals()
        points, face = sample(mesh, samples, 1)
        self.points, self.normals = points, self.face_normals[face]
        self.rank = np.random.default_rng(1).permutation(samples)

    def closest(self, P: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances (k,) of P (k, 3), and the unit vectors (k, 3) along which they grow."""
        distance, point, face = closest(self.surface, P)
        return distance, unit_vectors(P - point, distance, self.face_normals[face])

    def error(self, mesh: TriMesh, count: int, tree: ClosestPoints | None = None) -> float:
        """How far a mesh is from the source, unit frame, the worse way: the larger of the mean distances of `count` points
        each way.

        tree: of the mesh, where it is at hand."""
        there, _, _ = closest(self.surface, sample(mesh, count, 2)[0])
        back, _, _ = closest(tree or ClosestPoints(mesh), self.points[self.rank < count])
        return float(max(there.mean(), back.mean()))


def closest(surface: ClosestPoints, P: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What `surface.closest` says of P (k, 3), on every thread."""
    pieces = each(lambda first: surface.closest(P[first:first + PIECE]), range(0, len(P), PIECE))
    distance, point, face = (np.concatenate(part) for part in zip(*pieces, strict=True))
    return distance, point, face


def unit_vectors(away: np.ndarray, distance: np.ndarray, instead: np.ndarray) -> np.ndarray:
    """away / distance (k, 3); the rows of `instead` where the distance is next to nothing."""
    far = distance > 1e-9
    return np.where(far[:, None], away / np.maximum(distance, 1e-300)[:, None], instead)
