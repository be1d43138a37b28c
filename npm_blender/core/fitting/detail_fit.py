"""Integers of a displaced surface, stage by stage: each to the value with the least squared distance plus price of its bits.

The distances depend linearly on what is sent, as long as normals and closest points stay (see `two_way`). So a pass measures
them and improves the integers level by level on that model, one by one (coordinate descent).
"""
from typing import NamedTuple

import numpy as np

from ..displacement import DisplacedSurface, SurfaceLevels
from ..jit import compiled
from ..mesh import TriMesh
from ..parallel import each
from .influence import Columns
from .rates import Rate, bits_of, class_of, default_rate, measured_rate
from .source import Source
from .two_way import Samples, TwoWay

DAMPING = 0.01  # of a level's mean curvature, against steps where nothing is known
PER_UNKNOWN, MOST = 12, 150_000  # samples each way
TRADE = 0.06  # price of a bit, in squared steps of the finest level
SWEEPS = 3
BUSY = 0.1  # share of numbers of a level that are not zero, before the next level is looked at
REACH = 0.2  # of the length of its parent edge: how far a vertex moves in a pass


class Stencils(NamedTuple):
    """What the integers of one level do to the samples: start, row, push: columns; curvature (n,): squared, damped; reach (n,):
    how far each may move, and moved (n,): how far it has, in steps; samples: each way."""

    start: np.ndarray
    row: np.ndarray
    push: np.ndarray
    curvature: np.ndarray
    reach: np.ndarray
    moved: np.ndarray
    samples: int


class StageFit(NamedTuple):
    """What `DetailFit` finds: value (n,) int64 after a stage, in its steps; rate: bits measured from the last pass, which price
    the next stage; mean: the larger mean distance before the last pass, unit frame.

    >>> import numpy as np
    >>> from npm_blender.core.fitting import StageFit, default_rate
    >>> StageFit(np.array([0, -1, 2]), default_rate(levels=0), mean=0.01).value.tolist()
    [0, -1, 2]
    """

    value: np.ndarray
    rate: Rate
    mean: float


class DetailFit:
    """One source under one surface: finds the integers of a stage with the least squared distance plus price of their bits.

    Displacements as in Lee, Moreton, Hoppe 2000, chosen by rate and distortion and not by where a ray meets the source.

    >>> import numpy as np
    >>> from npm_blender.core import TriMesh
    >>> from npm_blender.core.bitstream import around
    >>> from npm_blender.core.displacement import DisplacedSurface
    >>> from npm_blender.core.fitting import DetailFit, Source
    >>> roof = TriMesh.from_arrays([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 0.1]],
    ...                            [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    >>> surface = DisplacedSurface(np.array([[0, 1, 2], [0, 2, 3]]), 4, levels=1, smooth=0)
    >>> fit = DetailFit(Source(roof, 2000), surface, around(surface.hierarchy))
    >>> found = fit.stage(roof.V[:4], np.array([0.05, 0.05]), None, levels=1)
    >>> before, after = (fit.error(roof.V[:4], value * 0.05, 1000) for value in (np.zeros(9), found.value))
    >>> bool(after < 0.6 * before)
    True
    """

    def __init__(self, source: Source, surface: DisplacedSurface, near: np.ndarray) -> None:
        """near (n, 8): the numbers around each, see `bitstream.around`."""
        self.source, self.surface, self.near = source, surface, near
        self._fits: dict[int, TwoWay] = {}

    def two_way(self, levels: int) -> TwoWay:
        """The fit of the first levels alone."""
        if levels not in self._fits:
            self._fits[levels] = TwoWay(self.source, self.surface.with_levels(levels))
        return self._fits[levels]

    def stage(self, V0: np.ndarray, steps: np.ndarray, before: StageFit | None, levels: int, trade: float = TRADE,
              passes: int = 2) -> StageFit:
        """The integers of a stage that refines the one before, whose steps were twice as large.

        steps (levels + 1,): of every level; levels: those that may have numbers; trade: price of a bit, in squared steps of the
        finest level."""
        old = 2 * before.value if before else np.zeros(int(self.surface.first[-1]), np.int64)
        rate = before.rate if before else default_rate(self.surface.levels)
        return self.improved(V0, steps, StageFit(old.copy(), rate, np.inf), old, levels, trade, passes)

    def improved(self, V0: np.ndarray, steps: np.ndarray, start: StageFit, old: np.ndarray, levels: int, trade: float = TRADE,
                 passes: int = 2) -> StageFit:
        """The integers of a stage, from those of `start`; old (n,): what changes are counted from."""
        first = self.surface.first
        per_vertex = np.repeat(steps, np.diff(first))
        value, rate = start.value.copy(), start.rate
        mean, best = np.inf, value
        for _ in range(passes):
            top = self._top(value, levels)
            fit = self.two_way(min(top + 1, self.surface.levels))
            unknown = int(first[top + 1] - first[top])
            moves = (value * per_vertex)[: int(fit.surface.first[-1])]
            at = fit.surface.build(V0, moves)
            samples = fit.measured(at.X[-1], steps[-1] / 2, min(PER_UNKNOWN * unknown, MOST))
            if samples.mean > mean:  # the pass before did harm
                return StageFit(best, rate, mean)
            mean, best = samples.mean, value.copy()
            per_bit = trade * steps[-1] ** 2 * self._finest_curvature(fit, samples)
            for level, model in enumerate(self._models(fit, samples, at, steps, top)):
                now, part = self.surface.new_at(level), samples.part(model.samples)
                before_level, scale = value[now].copy(), len(samples.distance) / len(part.distance)
                _descend(model, part.distance.copy(), value, old, self.near, np.array([now.start, SWEEPS]), rate.fresh[level],
                         rate.again, per_bit / scale)
                changed = value[now] - before_level
                if changed.any():
                    samples = fit.moved(samples, level, (changed * steps[level])[:, None] * at.N[level])
            rate = measured_rate(value, old, self.near, first)
        return StageFit(value, rate, mean)

    def _top(self, value: np.ndarray, levels: int) -> int:
        """The finest level that may have numbers: one more than those that are busy, and all that have some."""
        share = [np.count_nonzero(value[now]) / (now.stop - now.start) for now in map(self.surface.new_at, range(levels + 1))]
        some = max((i for i in range(levels + 1) if share[i]), default=0)
        busy = next((i for i in range(1, levels + 1) if share[i] < BUSY), levels)
        return max(some, busy)

    def _models(self, fit: TwoWay, samples: Samples, at: SurfaceLevels, steps: np.ndarray, top: int) -> list[Stencils]:
        """What the integers of levels 0..top do, each to as many samples as it needs."""
        def of(level: int) -> Stencils:
            count = PER_UNKNOWN * int(self.surface.first[level + 1] - self.surface.first[level])
            part = samples.part(count)
            return _stencils(fit.columns(part, level), part, at.N[level], steps[level], self._reach(at, level), count)

        return each(of, range(top, -1, -1))[::-1]

    def _reach(self, at: SurfaceLevels, level: int) -> np.ndarray:
        """How far (k,) the vertices that are new at a level may move in a pass: the model holds near where it was made."""
        if level == 0:
            edges = self.surface.hierarchy[0].edges
            length = np.linalg.norm(np.diff(at.X[0][edges], axis=1)[:, 0], axis=1)
            count = np.bincount(edges.reshape(-1), minlength=self.surface.n0)
            return REACH * np.bincount(edges.reshape(-1), np.repeat(length, 2), self.surface.n0) / np.maximum(count, 1)
        edges = self.surface.hierarchy[level - 1].edges
        return REACH * np.linalg.norm(np.diff(at.X[level - 1][edges], axis=1)[:, 0], axis=1)

    def error(self, V0: np.ndarray, moves: np.ndarray, count: int) -> float:
        """How far the finest level is from the source, the worse way, by `count` samples each way."""
        fit = self.two_way(self.surface.levels)
        X = fit.surface.build(V0, moves).X[-1]
        return self.source.error(TriMesh(X, fit.surface.hierarchy[-1].F), count, fit.tree(X))

    def _finest_curvature(self, fit: TwoWay, samples: Samples) -> float:
        """Of one vertex of the finest level of all: the weight that is spread over them, with the share of it that moves."""
        return 1.5 * samples.weight.sum() / len(self.surface.hierarchy[-1].edges)


def _stencils(columns: Columns, samples: Samples, N: np.ndarray, step: float, reach: np.ndarray, count: int) -> Stencils:
    push, curvature = _along(columns.start, columns.row, columns.weight, samples.away, N * step)
    curvature += DAMPING * curvature.mean()
    whole = np.maximum(np.rint(reach / step), 1).astype(np.int64)
    return Stencils(columns.start, columns.row, push, curvature, whole, np.zeros_like(whole), count)


@compiled(allocates=True)
def _along(start, row, weight, away, N):
    push, curvature = np.empty(len(row), np.float32), np.zeros(len(N))
    for j in range(len(N)):
        for p in range(start[j], start[j + 1]):
            k = row[p]
            push[p] = weight[p] * (away[k, 0] * N[j, 0] + away[k, 1] * N[j, 1] + away[k, 2] * N[j, 2])
            curvature[j] += push[p] * push[p]
    return push, curvature


@compiled
def _best_change(h, g, now, before, row, per_bit, least, most):
    """The change of an integer, 0 if none is better, with the least h x^2 / 2 + g x + price; row: bits by value.

    Tried are the two integers at the minimum without a price, the old value, and a step from the lower of the two towards
    the old value, all within least..most.
    """
    best, best_cost = 0, per_bit * bits_of(row, now - before)
    low = int(np.floor(min(max(-g / h, float(least)), float(most))))
    for trial in range(4):
        if trial == 0:
            step = low
        elif trial == 1:
            step = low + 1
        elif trial == 2:
            step = before - now
        else:
            step = low + (1 if low + now < before else -1)
        if step == 0 or step < least or step > most:
            continue
        cost = step * (0.5 * h * step + g) + per_bit * bits_of(row, now + step - before)
        if cost < best_cost:
            best, best_cost = step, cost
    return best


@compiled
def _descend(model, residual, value, old, near, plan, fresh, again, per_bit):
    """Coordinate descent over the integers value[plan[0]:], plan[1] times; the residual follows. None moves farther than
    model.reach from where it was."""
    start, row, push, reach = model.start, model.row, model.push, model.reach
    moved = model.moved
    for _ in range(plan[1]):
        changed = 0
        for i in range(len(reach)):
            if model.curvature[i] <= 0:
                continue
            v, g = plan[0] + i, 0.0
            for p in range(start[i], start[i + 1]):
                g += push[p] * residual[row[p]]
            bits = again if old[v] != 0 else fresh[class_of(value, near, v)]
            change = _best_change(model.curvature[i], g, value[v], old[v], bits, per_bit, -reach[i] - moved[i],
                                  reach[i] - moved[i])
            if change != 0:
                changed += 1
                value[v] += change
                moved[i] += change
                for p in range(start[i], start[i + 1]):
                    residual[row[p]] += push[p] * change
        if changed == 0:
            break
