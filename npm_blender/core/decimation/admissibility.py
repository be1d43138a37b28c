"""The tests that keep an edge collapse from turning a face over or ruining its shape, and how they grow milder at a price."""
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..jit import compiled
from ..parameterization import is_of_j, next_on_ring

QUALITY_SCALE = 3.4641  # 2 sqrt(3) in five digits: times |normal| / sum l^2 it gives the equilateral triangle the quality 1


class AdmissibilityTest(NamedTuple):
    """Tests of a collapse.

    price: factor on the quadric error when the queue orders collapses; cosine: least cosine between a face's normal
    before and after; quality: least face quality 4 sqrt(3) A / sum l^2 (or that of the stencil before, if lower); stretch:
    largest distortion of the conformal flattening, past which the one on a circle takes its place.
    """

    price: float
    cosine: float
    quality: float
    stretch: float


ADMISSIBILITY_TESTS = (
    AdmissibilityTest(1.0, 0.2, 0.01, 20.0),
    AdmissibilityTest(8.0, 0.1, 0.003, 1000.0),
    AdmissibilityTest(64.0, -0.5, 0.0, np.inf),
)


class TestColumns(NamedTuple):
    """Tests as arrays (k,) float64, one entry a test, for the compiled loop."""

    price: np.ndarray
    cosine: np.ndarray
    quality: np.ndarray
    stretch: np.ndarray

    @staticmethod
    def of(tests: Sequence[AdmissibilityTest]) -> "TestColumns":
        """The columns of these tests, which an edge meets one after the other."""
        return TestColumns(*(np.array(column, np.float64) for column in zip(*tests, strict=True)))


@compiled
def _normal(ax, ay, az, bx, by, bz, cx, cy, cz):
    """Area-weighted normal of a triangle, and the sum of its squared sides."""
    ux, uy, uz = bx - ax, by - ay, bz - az
    vx, vy, vz = cx - ax, cy - ay, cz - az
    wx, wy, wz = cx - bx, cy - by, cz - bz
    sides = ux * ux + uy * uy + uz * uz + vx * vx + vy * vy + vz * vz + wx * wx + wy * wy + wz * wz
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx, sides


@compiled
def shape_holds(X, stencil, point, cosine, quality):
    """Whether the faces of a stencil keep their direction and shape when i and j become one vertex at a point (ours).

    X (n, 3) float64: positions; point: a tuple x, y, z. No face may turn so far that the cosine between its normals before
    and after is below `cosine`; and the worst quality 4 sqrt(3) A / sum l^2 of a face afterwards (A its area, l its sides; 1
    for an equilateral triangle) may not be below `quality`, unless it was as bad before.

    >>> import numpy as np
    >>> from npm_blender.core.decimation import shape_holds
    >>> from npm_blender.core.parameterization import INNER, Stencil
    >>> X = np.array([[0, 0, 0], [1, 0, 0], [.5, -1, 0], [2, 0, 0], [.5, 1, 0], [-1, 0, 0]])  # i, j, and a ring of four
    >>> stencil = Stencil(INNER, np.array([2, 3, 4, 5], np.int32), np.zeros(6, np.int32), 4, 4, 0, 2, 0, 1)
    >>> [bool(shape_holds(X, stencil, (x, 0., 0.), 0.2, 0.01)) for x in (0.5, 3.0)]  # outside of the ring, faces turn over
    [True, False]
    """
    ring, i, j = stencil.ring, stencil.i, stencil.j
    x, y, z = point
    worst_before = worst_after = 1.0
    for q in range(stencil.sides):
        a, b = ring[q], ring[next_on_ring(stencil, q)]
        o = j if is_of_j(stencil, q) else i
        ax, ay, az, bx, by, bz = X[a, 0], X[a, 1], X[a, 2], X[b, 0], X[b, 1], X[b, 2]
        n0, n1, n2, l0 = _normal(X[o, 0], X[o, 1], X[o, 2], ax, ay, az, bx, by, bz)
        p0, p1, p2, l1 = _normal(x, y, z, ax, ay, az, bx, by, bz)
        n, p = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2), np.sqrt(p0 * p0 + p1 * p1 + p2 * p2)
        if n0 * p0 + n1 * p1 + n2 * p2 < cosine * n * p:
            return False
        worst_before = min(worst_before, QUALITY_SCALE * n / max(l0, 1e-300))
        worst_after = min(worst_after, QUALITY_SCALE * p / max(l1, 1e-300))
    return worst_after >= min(quality, worst_before)
