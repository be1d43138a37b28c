"""The triangle mesh that flows through the core: two arrays, checked once at the door."""
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError


@dataclass(frozen=True)
class TriMesh:
    """A triangle mesh.

    V: (n, 3) float64 vertex positions, in the units and frame of whoever made it.
    F: (m, 3) int32 vertex indices, counter-clockwise seen from outside.

    >>> from npm_blender.core.mesh import TriMesh
    >>> mesh = TriMesh.from_arrays([[0, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> mesh.V.dtype.name, mesh.F.dtype.name, mesh.face_areas().tolist()
    ('float64', 'int32', [1.0])
    """

    V: np.ndarray
    F: np.ndarray

    @staticmethod
    def from_arrays(V: ArrayLike, F: ArrayLike) -> "TriMesh":
        """Check and convert arrays from outside.

        V: (n, 3) real, F: (m, 3) integer. Raises MeshError if shapes or types are off, a coordinate is not finite,
        an index is out of range, or there are no faces.
        """
        V, F = np.asarray(V), np.asarray(F)
        if V.size == 0:
            raise MeshError("Expected a mesh with vertices, found none; select a mesh that has geometry")
        if F.size == 0:
            raise MeshError("Expected a mesh with faces, found none; add faces, or check that the file holds a surface")
        if V.ndim != 2 or V.shape[1] != 3 or V.dtype.kind not in "fiu":
            raise MeshError(f"Expected vertices (n, 3) of real numbers, got {V.shape} {V.dtype}")
        if F.ndim != 2 or F.shape[1] != 3 or F.dtype.kind not in "iu":
            raise MeshError(f"Expected triangles (m, 3) of integers, got {F.shape} {F.dtype}; triangulate the mesh first")
        V = np.ascontiguousarray(V, dtype=np.float64)
        bad = int((~np.isfinite(V)).any(1).sum())
        if bad:
            raise MeshError(f"Expected finite coordinates, found {bad} vertices with NaN or infinity; repair the mesh first")
        if F.min() < 0 or F.max() >= len(V):
            raise MeshError(f"Expected vertex indices 0..{len(V) - 1}, found {F.min()}..{F.max()}; the mesh is damaged")
        return TriMesh(V, np.ascontiguousarray(F, dtype=np.int32))

    def face_normals(self) -> np.ndarray:
        """Unit face normals (m, 3) float64; zero for faces without area."""
        a, b, c = self.V[self.F].swapaxes(0, 1)
        n = np.cross(b - a, c - a)
        return n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-300)

    def face_areas(self) -> np.ndarray:
        """Face areas (m,) float64, in squared units of V."""
        a, b, c = self.V[self.F].swapaxes(0, 1)
        return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


@dataclass(frozen=True)
class UnitFrame:
    """The similarity between object space and the unit frame, in which everything is encoded and measured.

    unit = (object - centre) / size: the bounding box is centred at the origin and its longest side is 1 (the paper's
    unit cube). centre: (3,) float64; size: float, object units.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import UnitFrame
    >>> frame = UnitFrame.of(np.array([[0.0, 0, 0], [4, 2, 0]]))
    >>> frame.to_unit(np.array([[4.0, 2, 0]])).tolist(), frame.size
    ([[0.5, 0.25, 0.0]], 4.0)
    """

    centre: np.ndarray
    size: float

    @staticmethod
    def of(V: np.ndarray) -> "UnitFrame":
        """The frame of points V (n, 3). Raises MeshError if they all coincide."""
        low, high = V.min(0), V.max(0)
        size = float((high - low).max())
        if not size > 0:
            raise MeshError("Expected a mesh with extent, found all vertices in one point; check its scale")
        return UnitFrame((low + high) / 2, size)

    def to_unit(self, V: np.ndarray) -> np.ndarray:
        """Object space (n, 3) to the unit frame."""
        return (V - self.centre) / self.size

    def to_object(self, V: np.ndarray) -> np.ndarray:
        """Unit frame (n, 3) back to object space; the inverse of `to_unit`."""
        return V * self.size + self.centre


def compact(V: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """V (n, 3) and F (m, 3) without unused vertices, order kept; F in its dtype, or int32 where vertices went.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import compact
    >>> V, F = compact(np.array([[9.0, 9, 9], [0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[1, 2, 3]]))
    >>> len(V), F.tolist()
    (3, [[0, 1, 2]])
    """
    used = np.zeros(len(V), bool)
    used[F] = True
    if used.all():
        return V, F
    return V[used], (np.cumsum(used) - 1).astype(np.int32)[F]
