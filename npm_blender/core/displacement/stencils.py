"""The subdivision scheme: from the vertices of a level to those of the next, as weighted sums (NumPy alone).

smooth 0 keeps vertices and puts new ones into the middles of edges; SMOOTHEST is Loop's scheme (Loop 1987), with cubic
B-splines along borders and creases (Hoppe et al. 1994); between is the blend of both.
"""
from typing import NamedTuple

import numpy as np

from ..mesh import Level, Sharp

SMOOTHEST = 8  # smooth is a whole number of 0..SMOOTHEST


class Stencil(NamedTuple):
    """Weights of one step of a subdivision scheme, n vertices to n + e.

    own (n,), around (n,) float64: of a vertex itself and of each neighbour that it sees, at its next place; start (n,),
    neighbour (k,): those neighbours, of vertex v from start[v] on (vertex v itself where it sees none, with weight 0);
    edges (e, 2): the ends of each edge, with weight end (e,); opposite (e, 2): the corners across, with weight across
    (e,), 0 on borders. Weights are float64, numbers of vertices int.

    >>> import numpy as np
    >>> from npm_blender.core.displacement import stencil_of
    >>> from npm_blender.core.mesh import Level
    >>> step = stencil_of(Level.of(np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]), 4), smooth=0)  # midpoints
    >>> step.apply(2 * np.eye(4)[:, :3])[4:6].tolist()
    [[1.0, 1.0, 0.0], [1.0, 0.0, 1.0]]
    """

    own: np.ndarray
    around: np.ndarray
    start: np.ndarray
    neighbour: np.ndarray
    edges: np.ndarray
    end: np.ndarray
    opposite: np.ndarray
    across: np.ndarray

    def apply(self, X: np.ndarray) -> np.ndarray:
        """Vertices (n + e, 3) of the next level, float64, from those (n, 3) of this one."""
        moved = X if not self.around.any() else (
            self.own[:, None] * X + self.around[:, None] * np.add.reduceat(X[self.neighbour], self.start, axis=0))
        new = self.end[:, None] * (X[self.edges[:, 0]] + X[self.edges[:, 1]])
        if self.across.any():
            new += self.across[:, None] * (X[self.opposite[:, 0]] + X[self.opposite[:, 1]])
        return np.concatenate([moved, new])

    def rows(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The same as rows of a sparse matrix (n + e, n): start (n + e + 1,) int64, index (k,) int32, weight (k,)."""
        n, e = len(self.own), len(self.edges)
        count = np.diff(np.append(self.start, len(self.neighbour)))
        even = np.repeat(np.arange(n), count)
        size = np.concatenate([1 + count, np.full(e, 4)])
        start = np.concatenate([[0], np.cumsum(size)])
        index, weight = np.empty(start[-1], np.int32), np.empty(start[-1])
        index[start[:n]], weight[start[:n]] = np.arange(n), self.own
        place = start[even] + 1 + np.arange(len(even)) - self.start[even]
        index[place], weight[place] = self.neighbour, self.around[even]
        odd = start[n:-1, None] + np.arange(4)
        index[odd] = np.concatenate([self.edges, self.opposite], 1)
        weight[odd] = np.stack([self.end, self.end, self.across, self.across], 1)
        return start, index, weight


def stencil_of(level: Level, smooth: int, sharp: Sharp | None = None) -> Stencil:
    """The step from a level to the next; smooth, a whole number of 0..SMOOTHEST, blends midpoints with Loop's scheme.

    Loop's weights (Loop 1987): 3/8 and 1/8 for a new vertex; for an old one of valence k its neighbours' are
    (5/8 - (3/8 + cos(2 pi / k) / 4)^2) / k. On borders and sharp edges 1/2 for a new vertex, and for an old one 1/8 of both
    neighbours along them; where more than two of them meet, and in a corner, a vertex stays (Hoppe et al. 1994).

    >>> import numpy as np
    >>> from npm_blender.core.displacement import SMOOTHEST, stencil_of
    >>> from npm_blender.core.mesh import Level
    >>> step = stencil_of(Level.of(np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]), 4), SMOOTHEST)
    >>> step.own.tolist(), step.end[0], step.across[0]  # valence 3: 3/16 for each neighbour
    ([0.4375, 0.4375, 0.4375, 0.4375], 0.375, 0.125)
    """
    share = smooth / SMOOTHEST
    n = level.n
    left, right = level.edge_halfedge.T.astype(np.int64)
    flat = level.F.reshape(-1)
    opposite = np.stack([flat[h - h % 3 + (h + 2) % 3] for h in (left, right)], 1)
    line = sharp.lines(level) if sharp else left == right
    lines = np.bincount(level.edges[line].reshape(-1), minlength=n)
    still = lines > 2 if sharp is None else (lines > 2) | sharp.corners
    on_line = lines == 2
    seen = (line[:, None] | ~on_line[level.edges]) & ~still[level.edges]  # a vertex on a line sees its neighbours there
    if not share:
        seen[:] = False
    ends = np.concatenate([level.edges[seen[:, 0]], level.edges[seen[:, 1]][:, ::-1]])
    valence = np.bincount(ends[:, 0], minlength=n)
    alone = np.flatnonzero(valence == 0)
    ends = np.concatenate([ends, np.stack([alone, alone], 1)])
    ends = ends[np.argsort(ends[:, 0], kind="stable")]
    k = np.maximum(valence, 1)
    around = (0.625 - (0.375 + 0.25 * np.cos(2 * np.pi / k)) ** 2) / k
    around = share * np.where(on_line, 1 / 8, around) * (valence > 0)
    start = np.concatenate([[0], np.cumsum(np.maximum(valence, 1))[:-1]])
    across = np.where(line, 0.0, share / 8)
    return Stencil(1 - valence * around, around, start, ends[:, 1], level.edges, 0.5 - across, opposite, across)
