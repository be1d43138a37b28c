"""Base vertices and integers that bring the finest level near an input, at a price per bit.

The finest level depends linearly on what is sent, as long as the normals stay. So each pass takes the distances of the
middles of its edges to the input, each along the line to its closest point, and improves base and integers level by
level on that quadratic model: integers one by one, each to the value with the least distance plus price times bits.
Squared distances are weighted by a power of 1 / distance, between plain squares and the sum that d_pm is.
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_matrix, diags, identity
from scipy.sparse.linalg import cg

from npm_blender.core.geometry import ClosestPoints
from npm_blender.core.jit import compiled
from npm_blender.core.mesh import TriMesh

from .shape import Scheme
from .stencils import edge_points
from .symbols import neighbours

POWER = 0.6  # see Fit; 1 would be what d_pm sums up, but lets go of what is far away
DAMPING = 0.01  # of a level's mean curvature, against steps where nothing is known
_SPRING = 0.01  # of the base's mean curvature, which holds its vertices where they are
_FLOOR = 2e-4  # distances below weigh no more in the fit of the base
_LARGEST = 6  # values of a rate table: 0..5, then two bits more per doubling
_CLASSES = 4
_TOUCHED = 1.5  # samples (weighted by their squared share) that a vertex of the finest level moves
_PER_UNKNOWN = 12  # samples for each number that is fitted
_DEFAULT = np.log2(1 / np.array([0.5, 0.3, 0.1, 0.05, 0.03, 0.02])) + np.array([0, 1, 1, 1, 1, 1.0])


class Target:
    """The input: its closest points."""

    def __init__(self, mesh: TriMesh) -> None:
        """mesh: in the unit frame."""
        self.surface = ClosestPoints(mesh)
        self.normals = mesh.face_normals()

    def residuals(self, P: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distance (k,) of P (k, 3), and the unit vector (k, 3) along which it grows."""
        distance, point, face = self.surface.closest(P)
        away = P - point
        far = distance > 1e-9
        out = np.where(far[:, None], away / np.maximum(distance, 1e-300)[:, None], self.normals[face])
        return distance, out


class Samples:
    """The middles of the finest level's edges in random order, and what moves them; a prefix of them is a sample."""

    def __init__(self, scheme: Scheme) -> None:
        """scheme: connectivity and matrices."""
        finest = scheme.hierarchy[-1]
        self.finest = finest
        self.order = np.random.default_rng(0).permutation(len(finest.edges))
        on_all = edge_points(finest)[self.order]
        self.points, self.by_level = on_all, []
        for level in range(scheme.levels, -1, -1):
            rows = min(on_all.shape[0], _PER_UNKNOWN * (3 if level == 0 else 1) * _new(scheme, level))
            self.by_level.append(csr_matrix(on_all[:rows, scheme.new_at(level)]))
            if level:
                on_all = csr_matrix(on_all @ scheme.matrices[level - 1])
        self.by_level.reverse()

    def __len__(self) -> int:
        return len(self.order)

    def area(self, X: np.ndarray) -> np.ndarray:
        """Share of the surface (e,) that each sample stands for; sums to 1."""
        area = TriMesh(X, self.finest.F).face_areas()
        share = np.bincount(self.finest.edge_of, np.repeat(area, 3), len(self.finest.edges))
        return share[self.order] / max(share.sum(), 1e-300)


def _new(scheme: Scheme, level: int) -> int:
    now = scheme.new_at(level)
    return now.stop - now.start


class Rate(NamedTuple):
    """Bits: fresh (levels + 1, classes, values) for a vertex whose old value is 0, by the size of what is around it;
    again (values,) for a change of another."""

    fresh: np.ndarray
    again: np.ndarray


def default_rate(levels: int) -> Rate:
    """Before anything is known."""
    return Rate(np.tile(_DEFAULT, (levels + 1, _CLASSES, 1)), _DEFAULT.copy())


@compiled
def _class(value, near, v):
    around = 0
    for t in range(6):
        if near[v, t] >= 0:
            around += min(abs(value[near[v, t]]), 3)
    return 0 if around == 0 else (1 if around < 3 else (2 if around < 6 else 3))


@compiled
def _bits(table, x):
    x = abs(x)
    if x < len(table):
        return table[x]
    return table[len(table) - 1] + 2 * np.log2(x / (len(table) - 1))


class Quadratic(NamedTuple):
    """x -> x A x / 2 - gradient x, of k integers as changes x: start, index, data: rows of A (CSR), diagonal (k,): A's.

    gradient (k,): minus the gradient where the integers are now; it follows their changes.
    """

    start: np.ndarray
    index: np.ndarray
    data: np.ndarray
    diagonal: np.ndarray
    gradient: np.ndarray

    @staticmethod
    def of(A: csr_matrix, gradient: np.ndarray) -> "Quadratic":
        """From the matrix."""
        return Quadratic(A.indptr, A.indices, A.data, A.diagonal(), gradient)


class Integers(NamedTuple):
    """value (n,) int64: of all vertices; old (n,): what changes are counted from; near (n, 8): symbols.neighbours."""

    value: np.ndarray
    old: np.ndarray
    near: np.ndarray


class Price(NamedTuple):
    """Of a change in squared distance: bits, fresh (classes, values) and again (values,) as in Rate, times per_bit."""

    fresh: np.ndarray
    again: np.ndarray
    per_bit: float


@compiled
def _best_change(h, g, now, before, row, per_bit):
    """The change of an integer, 0 if none is better, with the least h x^2 / 2 - g x + price; row: bits by value.

    Tried are the two integers at the minimum without a price, the old value, and a step from the lower of the two towards
    the old value.
    """
    best, best_cost = 0, per_bit * _bits(row, now - before)
    low = int(np.floor(g / h))
    for trial in range(4):
        if trial == 0:
            step = low
        elif trial == 1:
            step = low + 1
        elif trial == 2:
            step = before - now
        else:
            step = low + (1 if low + now < before else -1)
        if step == 0:
            continue
        cost = step * (0.5 * h * step - g) + per_bit * _bits(row, now + step - before)
        if cost < best_cost:
            best, best_cost = step, cost
    return best


@compiled
def _descend(model, integers, first, price, sweeps):
    """Coordinate descent over the integers value[first:], of which `model` tells the squared distance."""
    value, old, g = integers.value, integers.old, model.gradient
    for _ in range(sweeps):
        changed = 0
        for i in range(len(model.diagonal)):
            v = first + i
            if model.diagonal[i] <= 0:
                continue
            row = price.again if old[v] != 0 else price.fresh[_class(value, integers.near, v)]
            change = _best_change(model.diagonal[i], g[i], value[v], old[v], row, price.per_bit)
            if change != 0:
                changed += 1
                value[v] += change
                for p in range(model.start[i], model.start[i + 1]):
                    g[model.index[p]] -= model.data[p] * change
        if changed == 0:
            break


@compiled
def _count(value, old, near, first, fresh, again):
    """Counts of the values of each level and class into fresh and again."""
    largest = fresh.shape[2] - 1
    for level in range(len(first) - 1):
        for v in range(first[level], first[level + 1]):
            x = min(abs(value[v] - old[v]), largest)
            if old[v] != 0:
                again[x] += 1
            else:
                fresh[level, _class(value, near, v), x] += 1


def measured_rate(value: np.ndarray, old: np.ndarray, near: np.ndarray, first: np.ndarray) -> Rate:
    """Bits by what the values are."""
    prior = 2.0 ** -default_rate(len(first) - 2).fresh[0, 0] * 8
    fresh = np.tile(prior, (len(first) - 1, _CLASSES, 1))
    again = prior.copy()
    _count(value, old, near, first, fresh, again)
    sign = np.array([0, 1, 1, 1, 1, 1.0])
    return Rate(np.log2(fresh.sum(2, keepdims=True) / fresh) + sign, np.log2(again.sum() / again) + sign)


class State(NamedTuple):
    """Where the finest level is.

    N (n, 3): the direction in which each vertex is moved. Of k samples: distance (k,) to the input, away (k, 3): the unit
    vectors along which it grows, weight (k,): of its square; mean: distance, by area.
    """

    N: np.ndarray
    distance: np.ndarray
    away: np.ndarray
    weight: np.ndarray
    mean: float


class Fit:
    """One input under one scheme."""

    def __init__(self, target: Target, scheme: Scheme, power: float = POWER) -> None:
        """power: squares are weighted by distance ** -power: 1 sums distances, 0 plain squares."""
        self.target, self.scheme, self.power = target, scheme, power
        self.samples = Samples(scheme)
        self.near = neighbours(scheme.hierarchy)

    def _state(self, V0, d, floor, count):
        """The State of the first `count` samples; floor: distances below it weigh no more."""
        X, N = self.scheme.build(V0, d)
        r, u = self.target.residuals(self.samples.points[:count] @ X)
        area = self.samples.area(X)[:count]
        weight = area / (area.sum() * np.maximum(r, floor) ** self.power)
        return State(N, r, u, weight, float((area * r).sum() / area.sum()))

    def distance(self, V0: np.ndarray, d: np.ndarray, count: int = 20_000) -> float:
        """About d_pm / 1e4."""
        return self._state(V0, d, 1.0, count).mean

    def _base_system(self, V0, d, floor):
        """Normal equations A x = b of the base vertices' coordinates."""
        state = self._state(V0, d, floor, self.samples.by_level[0].shape[0])
        W = self.samples.by_level[0][: len(state.distance)]
        rows = np.repeat(np.arange(W.shape[0]), np.diff(W.indptr))
        data = (W.data[:, None] * state.away[rows]).reshape(-1)
        index = (3 * W.indices[:, None] + np.arange(3)).reshape(-1)
        count = np.diff(W.indptr)
        indptr = np.concatenate([[0], np.cumsum(3 * count)])
        order = np.argsort(np.repeat(np.arange(len(count)), 3 * count), kind="stable")
        J = csr_matrix((data[order], index[order], indptr), (W.shape[0], 3 * W.shape[1]))
        JT = J.T.tocsr() @ diags(state.weight[: len(count)])
        return csr_matrix(JT @ J), -(JT @ state.distance[: len(count)])

    def base(self, V0: np.ndarray, d: np.ndarray, passes: int = 6) -> np.ndarray:
        """Base vertices (n0, 3) moved to where the finest level is nearest to the input."""
        for _ in range(passes):
            A, b = self._base_system(V0, d, _FLOOR)
            pull = _SPRING * A.diagonal().mean()
            step, _ = cg(A + pull * identity(A.shape[0]), b, rtol=1e-3, maxiter=60)
            V0 = V0 + step.reshape(-1, 3)
        return V0

    def on_lattice(self, V0: np.ndarray, d: np.ndarray, bits: int) -> np.ndarray:
        """Lattice positions (n0, 3) int64 of step 2**-bits near V0, rounded so that the surface moves little."""
        A, b = self._base_system(V0, d, _FLOOR)
        step = 2.0**-bits
        ints = np.rint(V0 / step).astype(np.int64).reshape(-1)
        A = csr_matrix(A + _SPRING * A.diagonal().mean() * identity(A.shape[0]))
        g = (b - A @ (ints * step - V0.reshape(-1))) * step
        alone = np.full((len(ints), 8), -1, np.int32)
        free = Price(np.zeros((_CLASSES, _LARGEST)), np.zeros(_LARGEST), 0.0)
        _descend(Quadratic.of(A * step**2, g), Integers(ints, ints.copy(), alone), 0, free, 4)
        return ints.reshape(-1, 3)

    def integers(self, V0: np.ndarray, steps: np.ndarray, value: np.ndarray, old: np.ndarray, trade: float,
                 passes: int = 3, rate: Rate | None = None) -> tuple[np.ndarray, Rate]:
        """Integers (n,) improved from `value`, and the bits they were priced with.

        steps (levels + 1,): of each level; old (n,): what a change is counted from; trade: price of a bit in units of
        the squared finest step on one vertex.
        """
        scheme = self.scheme
        per_vertex = np.repeat(steps, np.diff(scheme.first))
        value = value.copy()
        rate = rate or default_rate(scheme.levels)
        finest = max((v for v in range(scheme.levels + 1) if value[scheme.new_at(v)].any()), default=0)
        for _ in range(passes):
            top = min(max(finest + 1, 1), scheme.levels)
            state = self._state(V0, value * per_vertex, steps[-1] / 2, self.samples.by_level[top].shape[0])
            # of one vertex of the finest level, wherever its samples lie
            count = len(state.distance)
            per_bit = trade * steps[-1] ** 2 * state.weight.mean() * count / len(self.samples) * _TOUCHED
            for level in range(top + 1):
                now, step = scheme.new_at(level), steps[level]
                before = value[now].copy()
                price = Price(rate.fresh[level], rate.again, per_bit)
                _descend(self._level_model(level, state, step), Integers(value, old, self.near), now.start, price, 3)
                moved = (value[now] - before) * step
                if moved.any():
                    finest = max(finest, level)
                    if level < top:
                        shift = self._move(level, top, moved, state.N[now], count)
                        state = state._replace(distance=state.distance + np.einsum("ij,ij->i", state.away, shift))
            rate = measured_rate(value, old, self.near, scheme.first)
        return value, rate

    def _level_model(self, level, state, step):
        """Weighted squared distance of the samples in changes of the integers that are new at a level."""
        N, r, u = state.N[self.scheme.new_at(level)], state.distance, state.away
        W = self.samples.by_level[level][: len(r)]
        k = W.shape[0]
        rows = np.repeat(np.arange(k), np.diff(W.indptr))
        J = csr_matrix((W.data * np.einsum("ij,ij->i", u[rows], N[W.indices]), W.indices, W.indptr), W.shape)
        JT = J.T.tocsr()
        JT = csr_matrix((JT.data * state.weight[JT.indices] * (step * len(r) / k), JT.indices, JT.indptr), JT.shape)
        A = csr_matrix(JT @ J) * step
        A = csr_matrix(A + DAMPING * A.diagonal().mean() * identity(A.shape[0]))
        return Quadratic.of(A, -(JT @ r[:k]))

    def _move(self, level: int, top: int, moved: np.ndarray, N: np.ndarray, count: int) -> np.ndarray:
        """How the first samples (count, 3) move when the vertices that are new at a level move along N (k, 3)."""
        X = np.zeros((self.scheme.hierarchy[level].n, 3))
        X[self.scheme.new_at(level)] = moved[:, None] * N
        for i in range(level, self.scheme.levels):
            X = self.scheme.matrices[i] @ X
        return self.samples.points[:count] @ X
