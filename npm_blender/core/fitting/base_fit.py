"""Base vertices that bring the surface near the source, freely and on a lattice (Gauss-Newton, block by block)."""
import numpy as np

from ..jit import compiled
from .two_way import TwoWay

SPRING = 0.01  # of the mean curvature, which holds vertices where they are
FLOOR = 2e-4  # distances below weigh no more
PER_VERTEX, MOST = 36, 120_000  # samples each way
SWEEPS, ROUNDINGS = 12, 4


def _count(fit: TwoWay) -> int:
    return min(PER_VERTEX * fit.surface.n0, MOST)


def fit_base(fit: TwoWay, V0: np.ndarray, moves: np.ndarray, passes: int) -> np.ndarray:
    """Base vertices (n0, 3) float64 from V0, so that the finest level, moved by `moves` (n,), is nearest to the source.

    passes: how often distances are measured anew; one that does harm is taken back, and ends the fit. Between, block Gauss-Seidel
    on their linear model (see `two_way`). A fit of the control mesh of a subdivision surface as in Hoppe, DeRose, Duchamp,
    Halstead, Jin, McDonald, Schweitzer, Stuetzle 1994 (*Piecewise smooth surface reconstruction*), both ways. Unit frame.

    >>> import numpy as np
    >>> from npm_blender.core import TriMesh
    >>> from npm_blender.core.displacement import DisplacedSurface
    >>> from npm_blender.core.fitting import Source, TwoWay, fit_base
    >>> square = TriMesh.from_arrays([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> fit = TwoWay(Source(square, 500), DisplacedSurface(square.F, 4, levels=1, smooth=0))
    >>> fitted = fit_base(fit, square.V + [0, 0, 0.1], np.zeros(9), passes=4)
    >>> bool(np.abs(fitted[:, 2]).max() < 1e-3)  # it was lifted by 0.1
    True
    """
    best, least = V0, np.inf
    for _ in range(passes):
        samples = fit.measured(fit.surface.build(V0, moves).X[-1], FLOOR, _count(fit))
        if samples.mean > least:
            return best
        best, least = V0, samples.mean
        columns = fit.columns(samples, 0)
        curvature = _curvature(*columns, samples.away)
        pull = SPRING * curvature[:, [0, 3, 5]].mean()
        V0 = V0 + _relaxed(*columns, samples.away, samples.distance.copy(), curvature, pull, SWEEPS)
    return V0


class Rounding:
    """Base vertices V0 (n0, 3) on lattices, rounded so that the surface moves little: a vertex makes up for what the rounding of
    those before it did (feedback rounding). Unit frame.

    >>> import numpy as np
    >>> from npm_blender.core import TriMesh
    >>> from npm_blender.core.displacement import DisplacedSurface
    >>> from npm_blender.core.fitting import Rounding, Source, TwoWay
    >>> square = TriMesh.from_arrays([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> fit = TwoWay(Source(square, 500), DisplacedSurface(square.F, 4, levels=0, smooth=0))
    >>> Rounding(fit, square.V, np.zeros(4)).on_lattice(1 / 8).tolist()
    [[0, 0, 0], [8, 0, 0], [8, 8, 0], [0, 8, 0]]
    """

    def __init__(self, fit: TwoWay, V0: np.ndarray, moves: np.ndarray) -> None:
        self.V0 = V0
        self._samples = fit.measured(fit.surface.build(V0, moves).X[-1], FLOOR, _count(fit))
        self._columns = fit.columns(self._samples, 0)
        self._curvature = _curvature(*self._columns, self._samples.away)

    def on_lattice(self, step: float) -> np.ndarray:
        """Integers (n0, 3) int64: positions over the step."""
        pull = SPRING * self._curvature[:, [0, 3, 5]].mean()
        V = self.V0 / step
        ints = np.rint(V).astype(np.int64)
        _round(*self._columns, self._samples.away * np.float64(step), self._samples.distance.copy(),
               self._curvature * step**2, pull * step**2, V, ints, ROUNDINGS)
        return ints


@compiled(allocates=True)
def _curvature(start, row, weight, away):
    """xx, xy, xz, yy, yz, zz (n, 6) of each vertex's block."""
    out = np.zeros((len(start) - 1, 6))
    for j in range(len(out)):
        for p in range(start[j], start[j + 1]):
            x, y, z = away[row[p], 0], away[row[p], 1], away[row[p], 2]
            w = weight[p] * weight[p]
            out[j, 0] += w * x * x
            out[j, 1] += w * x * y
            out[j, 2] += w * x * z
            out[j, 3] += w * y * y
            out[j, 4] += w * y * z
            out[j, 5] += w * z * z
    return out


@compiled
def _solve(A, j, pull, gx, gy, gz):
    """x with (A_j + pull) x = -g."""
    a, b, c = A[j, 0] + pull, A[j, 1], A[j, 2]
    d, e, f = A[j, 3] + pull, A[j, 4], A[j, 5] + pull
    xx, xy, xz = d * f - e * e, c * e - b * f, b * e - c * d
    yy, yz, zz = a * f - c * c, b * c - a * e, a * d - b * b
    s = -1.0 / (a * xx + b * xy + c * xz)
    return s * (xx * gx + xy * gy + xz * gz), s * (xy * gx + yy * gy + yz * gz), s * (xz * gx + yz * gy + zz * gz)


@compiled
def _gradient(start, row, weight, away, distance, j):
    gx, gy, gz = 0.0, 0.0, 0.0
    for p in range(start[j], start[j + 1]):
        k = row[p]
        w = weight[p] * distance[k]
        gx += w * away[k, 0]
        gy += w * away[k, 1]
        gz += w * away[k, 2]
    return gx, gy, gz


@compiled
def _move(start, row, weight, away, distance, j, x, y, z):
    for p in range(start[j], start[j + 1]):
        k = row[p]
        distance[k] += weight[p] * (x * away[k, 0] + y * away[k, 1] + z * away[k, 2])


@compiled(allocates=True)
def _relaxed(start, row, weight, away, distance, curvature, pull, sweeps):
    """Steps (n, 3) of all vertices: block Gauss-Seidel."""
    out = np.zeros((len(curvature), 3))
    for _ in range(sweeps):
        for j in range(len(out)):
            gx, gy, gz = _gradient(start, row, weight, away, distance, j)
            x, y, z = _solve(curvature, j, pull, gx + pull * out[j, 0], gy + pull * out[j, 1], gz + pull * out[j, 2])
            _move(start, row, weight, away, distance, j, x, y, z)
            out[j, 0] += x
            out[j, 1] += y
            out[j, 2] += z
    return out


@compiled
def _round(start, row, weight, away, distance, curvature, pull, V, ints, sweeps):
    """Integers in place: each vertex in turn takes the best of the 27 about its optimum, given the others as they are."""
    A = curvature
    for j in range(len(ints)):
        _move(start, row, weight, away, distance, j, ints[j, 0] - V[j, 0], ints[j, 1] - V[j, 1], ints[j, 2] - V[j, 2])
    for _ in range(sweeps):
        changed = 0
        for j in range(len(ints)):
            gx, gy, gz = _gradient(start, row, weight, away, distance, j)
            gx += pull * (ints[j, 0] - V[j, 0])
            gy += pull * (ints[j, 1] - V[j, 1])
            gz += pull * (ints[j, 2] - V[j, 2])
            x, y, z = _solve(A, j, pull, gx, gy, gz)
            # at most four lattice steps from the optimum of the free fit
            x, y, z = min(max(np.rint(x), -4.0), 4.0), min(max(np.rint(y), -4.0), 4.0), min(max(np.rint(z), -4.0), 4.0)
            best, bx, by, bz = 0.0, 0.0, 0.0, 0.0
            for t in range(27):
                dx, dy, dz = x + t % 3 - 1, y + t // 3 % 3 - 1, z + t // 9 - 1
                cost = (dx * gx + dy * gy + dz * gz + dx * dy * A[j, 1] + dx * dz * A[j, 2] + dy * dz * A[j, 4]
                        + (dx * dx * (A[j, 0] + pull) + dy * dy * (A[j, 3] + pull) + dz * dz * (A[j, 5] + pull)) / 2)
                if cost < best:
                    best, bx, by, bz = cost, dx, dy, dz
            if best < 0:
                changed += 1
                ints[j, 0] += int(bx)
                ints[j, 1] += int(by)
                ints[j, 2] += int(bz)
                _move(start, row, weight, away, distance, j, bx, by, bz)
        if changed == 0:
            break
