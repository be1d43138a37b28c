"""The surface that is fitted, and points of it in random order: any first part of them is spread evenly."""
import numpy as np

from ..geometry import ClosestPoints, sample
from ..mesh import TriMesh
from ..parallel import each

SAMPLES = 200_000
PIECE = 16_384  # points that one thread looks up at a time


class Source:
    """points (SAMPLES, 3), and the unit normals (SAMPLES, 3) of the surface there; unit frame."""

    def __init__(self, mesh: TriMesh, samples: int = SAMPLES) -> None:
        """mesh: in the unit frame. Raises MeshError if it has no area."""
        self.surface, self.face_normals = ClosestPoints(mesh), mesh.face_normals()
        points, face = sample(mesh, samples, 1)
        order = np.random.default_rng(1).permutation(samples)
        self.points, self.normals = points[order], self.face_normals[face[order]]

    def closest(self, P: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances (k,) of P (k, 3), and the unit vectors (k, 3) along which they grow."""
        distance, point, face = closest(self.surface, P)
        return distance, unit_vectors(P - point, distance, self.face_normals[face])


    def error(self, mesh: TriMesh, count: int) -> float:
        """How far a mesh is from the source, the worse way: the larger of the mean distances of `count` points each way."""
        points, _ = sample(mesh, count, 2)
        there, _, _ = closest(self.surface, points)
        back, _, _ = closest(ClosestPoints(mesh), self.points[:count])
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
