"""Midpoint (1-to-4) subdivision: the connectivity that sender and receiver share.

Vertices: those of level i come first, then one per edge, edges sorted by (smaller, larger) vertex index; so the
vertices of a level are a prefix of those of every finer level. Faces: face f = (a, b, c) with edge midpoints
ab, bc, ca has the children 4f..4f+3 = (a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca): corner child k starts at
parent corner k; slot k of the centre child is the midpoint of the parent's half-edge k.
"""
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .radix_order import radix_argsort
from .topology import directed_edges, next_halfedges, paired_halfedges, prev_halfedges


@dataclass(frozen=True)
class Level:
    """Connectivity of one level of detail.

    F (m, 3) int32 faces; n: vertex count; opposite (3 m,) int32 (see topology); edges (e, 2) int32 sorted vertex pairs,
    whose midpoints are vertices n..n+e-1 of the next level; edge_of (3 m,) int32: edge of each half-edge;
    edge_halfedge (e, 2) int32: the half-edge that runs from the smaller to the larger vertex (or the only one, on the
    border) and its opposite.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import Level
    >>> level = Level.of(np.array([[0, 1, 2]]), 3)
    >>> level.edges.tolist()
    [[0, 1], [0, 2], [1, 2]]
    >>> level.subdivided().F.tolist()  # vertices 3, 4, 5 are the edges' midpoints
    [[0, 3, 4], [1, 5, 3], [2, 4, 5], [3, 5, 4]]
    """

    F: np.ndarray
    n: int
    opposite: np.ndarray
    edges: np.ndarray
    edge_of: np.ndarray
    edge_halfedge: np.ndarray

    @staticmethod
    def of(F: np.ndarray, n: int) -> "Level":
        """The level with faces F (m, 3) and n vertices. Raises MeshError if F is not an oriented edge-manifold."""
        F = np.ascontiguousarray(F, dtype=np.int32)
        order, first, opposite = paired_halfedges(F)
        edge_of = np.empty(F.size, np.int32)
        edge_of[order] = np.cumsum(first, dtype=np.int32) - 1
        one = order[first].astype(np.int32)
        two = opposite[one]
        a, b = directed_edges(F)[one].T
        swap = (a > b) & (two != one)
        left, right = np.where(swap, two, one), np.where(swap, one, two)
        return Level(F, int(n), opposite, np.stack([np.minimum(a, b), np.maximum(a, b)], 1), edge_of, np.stack([left, right], 1))

    def subdivided(self) -> "Level":
        """The next finer level, 4 m faces and n + e vertices: what `Level.of` finds, without looking for it."""
        n, h = self.n, np.arange(self.F.size, dtype=np.int32)
        first, second, across, centre = children = ChildHalfedges.of(h)
        opposite = children.opposite(self.opposite)
        border = self.opposite == h
        # edges: the halves, by their old vertex; then those between middles
        halves = radix_argsort(self.edges.reshape(-1))
        rank = np.empty(len(halves), np.int32)
        rank[halves] = np.arange(len(halves), dtype=np.int32)
        late = (self.F.reshape(-1) != self.edges[self.edge_of, 0]).astype(np.int32)
        one, two = n + self.edge_of, n + self.edge_of[prev_halfedges(h)]
        low, high = np.minimum(one, two), np.maximum(one, two)
        inner = radix_argsort(low.astype(np.int64) * (n + len(self.edges)) + high)
        edge_of = np.empty(4 * len(h), np.int32)
        edge_of[first], edge_of[second] = rank[2 * self.edge_of + late], rank[2 * self.edge_of + 1 - late]
        edge_of[across[inner]] = edge_of[centre[inner]] = len(halves) + np.arange(len(inner), dtype=np.int32)
        edges = np.empty((len(halves) + len(inner), 2), np.int32)
        edges[:len(halves), 0], edges[:len(halves), 1] = self.edges.reshape(-1)[halves], n + halves // 2
        edges[len(halves):, 0], edges[len(halves):, 1] = low[inner], high[inner]
        left = np.empty(len(edges), np.int32)
        left[edge_of[second[border]]] = second[border]
        left[edge_of[first]] = first
        left[edge_of[across]] = np.where(one < two, across, centre)
        F = subdivide_faces(self.F, self.edge_of, n)
        return Level(F, n + len(self.edges), opposite, edges, edge_of, np.stack([left, opposite[left]], 1))


class ChildHalfedges(NamedTuple):
    """The half-edges of the children that belong to each half-edge h = 3 f + k of their parents; together all 12 m.

    first and second (3 m,): halves of h, slot 0 of child k and slot 2 of the next child; across (3 m,): slot 1 of child k,
    from the middle of h to that of prev(h); centre (3 m,): its opposite, slot k - 1 of the child in the centre.
    """

    first: np.ndarray
    second: np.ndarray
    across: np.ndarray
    centre: np.ndarray

    @staticmethod
    def of(h: np.ndarray) -> "ChildHalfedges":
        """Those of all half-edges h = 0..3 m - 1, in the dtype of h."""
        child, after = 4 * (h // 3), next_halfedges(h) % 3
        across = 3 * (child + h % 3) + 1
        return ChildHalfedges(across - 1, 3 * (child + after) + 2, across, 3 * (child + 3) + prev_halfedges(h) % 3)

    def opposite(self, opposite: np.ndarray) -> np.ndarray:
        """Opposite half-edges (12 m,) of the children, in this table's dtype, from those (3 m,) of their parents."""
        border = opposite == np.arange(len(opposite))
        out = np.empty(4 * len(opposite), self.first.dtype)
        out[self.first] = np.where(border, self.first, self.second[opposite])
        out[self.second] = np.where(border, self.second, self.first[opposite])
        out[self.across], out[self.centre] = self.centre, self.across
        return out


def subdivide_faces(F: np.ndarray, edge_of: np.ndarray, n: int) -> np.ndarray:
    """Child faces (4 m, 3) int32 of F (m, 3), in the order that the module describes."""
    a, b, c = F.T
    ab, bc, ca = (n + edge_of.reshape(-1, 3)).T
    children = np.stack([a, ab, ca, b, bc, ab, c, ca, bc, ab, bc, ca], 1)
    return np.ascontiguousarray(children.reshape(-1, 3), dtype=np.int32)


def hierarchy(F0: np.ndarray, n0: int, levels: int) -> list[Level]:
    """Levels 0..levels of the base faces F0 (m, 3) over n0 vertices. Raises MeshError if F0 is not a manifold.

    Level i has 4^i m faces, in the numbering that the module describes.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import hierarchy
    >>> [(len(level.F), level.n) for level in hierarchy(np.array([[0, 1, 2], [0, 2, 3]]), 4, 2)]
    [(2, 4), (8, 9), (32, 25)]
    """
    out = [Level.of(F0, n0)]
    for _ in range(levels):
        out.append(out[-1].subdivided())
    return out


def midpoints(V: np.ndarray, level: Level) -> np.ndarray:
    """V (n, ...) followed by the mean of each edge's ends, (n + e, ...): the level's own vertices at the next level.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import Level, midpoints
    >>> midpoints(np.array([[0.0, 0, 0], [2, 0, 0], [0, 4, 0]]), Level.of(np.array([[0, 1, 2]]), 3))[3:].tolist()
    [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [1.0, 2.0, 0.0]]
    """
    return np.concatenate([V, (V[level.edges[:, 0]] + V[level.edges[:, 1]]) / 2])


def subdivided_opposite(opposite: np.ndarray) -> np.ndarray:
    """Opposite half-edges (12 m,) int64 of the subdivided faces, given those (3 m,) of the faces; see `ChildHalfedges`.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import subdivided_opposite
    >>> subdivided_opposite(np.array([0, 1, 2])).reshape(4, 3).tolist()  # one face: only its centre child has three neighbours
    [[0, 11, 2], [3, 9, 5], [6, 10, 8], [4, 7, 1]]
    """
    return ChildHalfedges.of(np.arange(len(opposite))).opposite(opposite)
