"""How far a decoded mesh is from its original, and how much smaller: the measures of paper section 4.1."""
from dataclasses import dataclass

import numpy as np

from ..errors import MeshError
from ..geometry import ClosestPoints, sample
from ..mesh import TriMesh, UnitFrame

DISTANCE_UNIT = 1e-4  # of the unit cube's side, as the paper's tables print distances


@dataclass(frozen=True)
class Metrics:
    """Distances between a decoded mesh and its original, in the original's unit cube (longest side of its box 1).

    d_pm: mean distance of points of the decoded surface to the original, in 1e-4 of the unit cube's side (paper).
    d_normal: mean angle between the face normals at those points and at their closest points, in degrees, 0 to 180
    (paper). d_reverse: mean distance of points of the original to the decoded surface, in 1e-4 of the side: what the
    decoded mesh does not cover. d_p99: the distance that 99 of 100 points of the decoded surface stay within, d_max: the
    largest distance of a point either way (at most the Hausdorff distance), both in 1e-4 of the side. The last three are ours.

    >>> from npm_blender.core.evaluation import Metrics
    >>> measured = Metrics(d_pm=3.0, d_normal=2.5, d_reverse=3.5, d_p99=9.0, d_max=20.0)
    >>> round(measured.d_pm * 1e-4 * 2.0, 6)  # of an original whose box is 2 m long, in metres
    0.0006
    >>> measured.worse
    3.5
    """

    d_pm: float
    d_normal: float
    d_reverse: float
    d_p99: float
    d_max: float

    @property
    def worse(self) -> float:
        """The larger of d_pm and d_reverse, in 1e-4 of the side: the one figure by which files are compared.

        A decoded mesh that lies near the original but leaves a part of it out has a small d_pm, and a mesh with a part too
        many a small d_reverse; neither has a small `worse`.
        """
        return max(self.d_pm, self.d_reverse)


class Original:
    """An original, ready to be compared with many decoded meshes: its search structure and samples are made once.

    >>> from npm_blender.core import TriMesh
    >>> from npm_blender.core.evaluation import Original
    >>> square = TriMesh.from_arrays([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> lifted = TriMesh(square.V + [0, 0, 0.001], square.F)
    >>> original = Original(square, samples=100)
    >>> [round(original.evaluate(mesh).d_pm, 6) for mesh in (square, lifted)]
    [0.0, 10.0]
    >>> round(original.worse(lifted, samples=50), 6)
    10.0
    """

    def __init__(self, mesh: TriMesh, samples: int = 1_000_000, seed: int = 0) -> None:
        """mesh: any frame; samples: points per direction; the same seed gives the same points.

        Raises MeshError if the mesh has no extent or no area. Faces without area are left out: they have no normal.
        """
        self._frame = UnitFrame.of(mesh.V)
        self._mesh = _with_area(TriMesh(self._frame.to_unit(mesh.V), mesh.F), "original")
        self._surface = ClosestPoints(self._mesh)
        self._normals = self._mesh.face_normals()
        self._samples, self._seed = samples, seed
        self._points = {samples: sample(self._mesh, samples, seed)[0]}

    def evaluate(self, decoded: TriMesh) -> Metrics:
        """Metrics of `decoded`, in the same frame as the original. Raises MeshError if it has no area."""
        decoded = self._in_unit(decoded)
        points, face = sample(decoded, self._samples, self._seed)
        distance, _, nearest = self._surface.closest(points)
        angle = _angle(decoded.face_normals()[face], self._normals[nearest])
        reverse = self._reverse(decoded, self._samples)
        return Metrics(d_pm=float(distance.mean() / DISTANCE_UNIT), d_normal=float(np.degrees(angle.mean())),
                       d_reverse=float(reverse.mean() / DISTANCE_UNIT),
                       d_p99=float(np.percentile(distance, 99) / DISTANCE_UNIT),
                       d_max=float(max(distance.max(), reverse.max()) / DISTANCE_UNIT))

    def worse(self, decoded: TriMesh, samples: int) -> float:
        """`Metrics.worse` of `decoded` alone, in 1e-4 of the side, from so many points each way: for searches.

        With the samples of the constructor it is what `evaluate` finds. Raises MeshError if `decoded` has no area.
        """
        decoded = self._in_unit(decoded)
        there = self._surface.closest(sample(decoded, samples, self._seed)[0])[0].mean()
        return float(max(there, self._reverse(decoded, samples).mean()) / DISTANCE_UNIT)

    def _reverse(self, decoded: TriMesh, samples: int) -> np.ndarray:
        """Distances (samples,) of points of the original to `decoded`, which is in the unit frame."""
        if samples not in self._points:
            self._points[samples] = sample(self._mesh, samples, self._seed)[0]
        return ClosestPoints(decoded).closest(self._points[samples])[0]

    def _in_unit(self, decoded: TriMesh) -> TriMesh:
        return _with_area(TriMesh(self._frame.to_unit(decoded.V), decoded.F), "decoded mesh")


def evaluate(decoded: TriMesh, original: TriMesh, samples: int = 1_000_000, seed: int = 0) -> Metrics:
    """Metrics of `decoded` against `original`, both in the same frame; `samples` points each way.

    d_pm = 10^4 / n sum_i min_q |p_i - q|, over n points p_i of the decoded surface and the points q of the original, in its unit
    cube (paper section 4.1). Deterministic for a seed. Raises MeshError if either has no area. Use `Original` to compare many
    with one.

    >>> from npm_blender.core import TriMesh
    >>> from npm_blender.core.evaluation import evaluate
    >>> square = TriMesh.from_arrays([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> lifted = TriMesh(square.V + [0, 0, 0.001], square.F)
    >>> measured = evaluate(lifted, square, samples=100)
    >>> round(measured.d_pm, 6), round(measured.d_max, 6), round(measured.d_normal, 6)
    (10.0, 10.0, 0.0)
    """
    return Original(original, samples, seed).evaluate(decoded)


def compression_ratio(source_vertices: int, base_vertices: int, numbers: int) -> float:
    """The paper's CR = 3 |V| / (3 |V^0| + numbers): coordinates before, over coordinates and components of features
    after. Connectivity, indices and entropy coding are not counted (paper section 4.1).

    >>> from npm_blender.core.evaluation import compression_ratio
    >>> compression_ratio(source_vertices=50_000, base_vertices=200, numbers=2_400)
    50.0
    """
    return 3 * source_vertices / (3 * base_vertices + numbers)


def _with_area(mesh: TriMesh, name: str) -> TriMesh:
    kept = mesh.F[mesh.face_areas() > 0]
    if len(kept) == 0:
        raise MeshError(f"Expected the {name} to have a surface, found only faces of zero area; check the file")
    return TriMesh(mesh.V, kept)


def _angle(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angle between rows of unit vectors (n, 3), in radians; accurate near 0, where arccos is not."""
    return 2 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
