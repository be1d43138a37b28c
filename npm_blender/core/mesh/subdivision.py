"""Midpoint (1-to-4) subdivision: the connectivity that sender and receiver share.

Vertices: those of level i come first, then one per edge, edges sorted by (smaller, larger) vertex index; so the
vertices of a level are a prefix of those of every finer level. Faces: face f = (a, b, c) with edge midpoints
ab, bc, ca has the children 4f..4f+3 = (a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca): corner child k starts at
parent corner k; slot k of the centre child is the midpoint of the parent's half-edge k.
"""
from dataclasses import dataclass

import numpy as np

from .radix_order import radix_argsort
from .topology import directed_edges, paired_halfedges


@dataclass(frozen=True)
class Level:
    """Connectivity of one level of detail.

    F (m, 3) int32 faces; n: vertex count; opposite (3 m,) int32 (see topology); edges (e, 2) int32 sorted vertex pairs,
    whose midpoints are vertices n..n+e-1 of the next level; edge_of (3 m,) int32: edge of each half-edge;
    edge_halfedge (e, 2) int32: the half-edge that runs from the smaller to the larger vertex (or the only one, on the
    border) and its opposite.
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
        """The next finer level, 4 m faces and n + e vertices: what `Level.of` finds, without looking for it.

        Half-edge k of a parent is halved by slot 0 of child k and slot 2 of the next child; slot 1 of child k runs from the
        middle of half-edge k to that of the one before, opposite to slot k - 1 of the child in the centre.
        """
        m, n, h = len(self.F), self.n, np.arange(self.F.size, dtype=np.int32)
        k, child = h % 3, 4 * (h // 3)
        first, second = 3 * (child + k), 3 * (child + (k + 1) % 3) + 2
        across, centre = 3 * (child + k) + 1, 3 * (child + 3) + (k + 2) % 3
        border = self.opposite == h
        opposite = np.empty(12 * m, np.int32)
        opposite[first] = np.where(border, first, second[self.opposite])
        opposite[second] = np.where(border, second, first[self.opposite])
        opposite[across], opposite[centre] = centre, across
        # edges: the halves, by their old vertex; then those between middles
        halves = radix_argsort(self.edges.reshape(-1))
        rank = np.empty(len(halves), np.int32)
        rank[halves] = np.arange(len(halves), dtype=np.int32)
        late = (self.F.reshape(-1) != self.edges[self.edge_of, 0]).astype(np.int32)
        one, two = n + self.edge_of, n + self.edge_of[h - k + (k + 2) % 3]
        low, high = np.minimum(one, two), np.maximum(one, two)
        inner = radix_argsort(low.astype(np.int64) * (n + len(self.edges)) + high)
        edge_of = np.empty(12 * m, np.int32)
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


def subdivide_faces(F: np.ndarray, edge_of: np.ndarray, n: int) -> np.ndarray:
    """Child faces (4 m, 3) int32 of F (m, 3), in the order that the module describes."""
    a, b, c = F.T
    ab, bc, ca = (n + edge_of.reshape(-1, 3)).T
    children = np.stack([a, ab, ca, b, bc, ab, c, ca, bc, ab, bc, ca], 1)
    return np.ascontiguousarray(children.reshape(-1, 3), dtype=np.int32)


def hierarchy(F0: np.ndarray, n0: int, levels: int) -> list[Level]:
    """Levels 0..levels of the base faces F0 (m, 3) over n0 vertices. Raises MeshError if F0 is not a manifold."""
    out = [Level.of(F0, n0)]
    for _ in range(levels):
        out.append(out[-1].subdivided())
    return out


def midpoints(V: np.ndarray, level: Level) -> np.ndarray:
    """V (n, ...) followed by the mean of each edge's ends, (n + e, ...): the level's own vertices at the next level."""
    return np.concatenate([V, (V[level.edges[:, 0]] + V[level.edges[:, 1]]) / 2])


def subdivided_opposite(opposite: np.ndarray) -> np.ndarray:
    """Opposite half-edges (12 m,) of the subdivided faces, given those (3 m,) of the faces; see `subdivide`."""
    m = len(opposite) // 3
    h = np.arange(3 * m)
    f, k = h // 3, h % 3
    after = h // 3 * 3 + (k + 1) % 3
    half_one, half_two = 3 * (h // 3 * 4 + k), 3 * (after // 3 * 4 + after % 3) + 2
    border = opposite == h
    out = np.empty(12 * m, dtype=np.int64)
    out[half_one] = np.where(border, half_one, half_two[opposite])
    out[half_two] = np.where(border, half_two, half_one[opposite])
    inner, centre = 3 * (4 * f + (k + 1) % 3) + 1, 3 * (4 * f + 3) + k
    out[inner], out[centre] = centre, inner
    return out
