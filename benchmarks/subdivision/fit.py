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
from npm_blender.core.mesh import TriMesh

from .descent import Integers, Price, Quadratic, descend
from .rates import CLASSES, VALUES, Rate, default_rate, measured_rate
from .shape import Scheme
from .stencils import edge_points
from .symbols import neighbours

POWER = 0.6  # see Fit; 1 would be what d_pm sums up, but lets go of what is far away
DAMPING = 0.01  # of a level's mean curvature, against steps where nothing is known
_SPRING = 0.01  # of the base's mean curvature, which holds its vertices where they are
_FLOOR = 2e-4  # distances below weigh no more in the fit of the base
_TOUCHED = 1.5  # samples (weighted by their squared share) that a vertex of the finest level moves
_PER_UNKNOWN = 12  # samples for each number that is fitted


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
        free = Price(np.zeros((CLASSES, VALUES)), np.zeros(VALUES), 0.0)
        descend(Quadratic.of(A * step**2, g), Integers(ints, ints.copy(), alone), 0, free, 4)
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
                descend(self._level_model(level, state, step), Integers(value, old, self.near), now.start, price, 3)
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
