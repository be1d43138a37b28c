"""Distances to a surface in Blender's process: built and asked in short steps, so that the window never waits.

The core's search for closest points is compiled code that takes seconds to load the first time. Blender has one of its
own, but building it for a large mesh holds the window up; so the surface is cut into patches with one search each, and a
point asks only those whose box is nearer than what it has found.
"""
from collections.abc import Generator
from typing import TYPE_CHECKING

from .threads import in_thread

if TYPE_CHECKING:
    import numpy as np

    from ..core.mesh import TriMesh

PATCH_FACES = 12_000  # some 10 ms each
POINTS_AT_ONCE = 400


class Nearest:
    """The surface of a mesh. `build` it, then ask for `distances`; both are generators that yield between steps."""

    def __init__(self, mesh: "TriMesh") -> None:
        """mesh: any TriMesh; the frame of the points that will be asked."""
        self._mesh: TriMesh | None = mesh
        self._trees: list = []
        self._low: list = []
        self._high: list = []
        self._building: Generator[None, None, None] | None = None

    @property
    def is_built(self) -> bool:
        """Whether distances can be asked."""
        return self._mesh is None

    def build(self) -> Generator[None, None, None]:
        """The steps that are still to do; who stops in between may go on with another call."""
        if self._building is None:
            self._building = self._patches()
        yield from self._building

    def _patches(self) -> Generator[None, None, None]:
        import numpy as np
        from mathutils.bvhtree import BVHTree

        from ..core.mesh import in_morton_order

        mesh = yield from in_thread(lambda: in_morton_order(self._mesh))
        for start in range(0, len(mesh.F), PATCH_FACES):
            used, F = np.unique(mesh.F[start:start + PATCH_FACES], return_inverse=True)
            V = mesh.V[used]
            self._trees.append(BVHTree.FromPolygons(V.tolist(), F.reshape(-1, 3).tolist(), all_triangles=True))
            self._low.append(V.min(0))
            self._high.append(V.max(0))
            yield
        self._mesh = None

    def distances(self, P: "np.ndarray") -> "Generator[None, None, np.ndarray]":
        """Distance of each of the points P (n, 3) to the surface, (n,) float32, as the generator's return value."""
        import numpy as np

        low, high = np.array(self._low), np.array(self._high)
        found = np.zeros(len(P), dtype=np.float32)
        for start in range(0, len(P), POINTS_AT_ONCE):
            points = P[start:start + POINTS_AT_ONCE].astype(np.float64)
            outside = np.maximum(np.maximum(low - points[:, None], points[:, None] - high), 0)
            bound = np.sqrt((outside * outside).sum(2))
            order = np.argsort(bound, axis=1)
            found[start:start + len(points)] = [
                self._distance(point, near, bounds)
                for point, near, bounds in zip(points.tolist(), order.tolist(), bound.tolist(), strict=True)]
            yield
        return found

    def _distance(self, point: list[float], near: list[int], bounds: list[float]) -> float:
        best = float("inf")
        for k in near:
            if bounds[k] >= best:
                break
            distance = self._trees[k].find_nearest(point, min(2 * best, 1e19))[3]
            if distance is not None and distance < best:
                best = distance
        return best
