"""Midpoint (1-to-4) subdivision: the connectivity that sender and receiver share.

Vertices: those of level i come first, then one per edge, edges sorted by (smaller, larger) vertex index; so the
vertices of a level are a prefix of those of every finer level. Faces: face f = (a, b, c) with edge midpoints
ab, bc, ca has the children 4f..4f+3 = (a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca): corner child k starts at
parent corner k; slot k of the centre child is the midpoint of the parent's half-edge k.
"""
from dataclasses import dataclass

import numpy as np

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
        """The next finer level, 4 m faces and n + e vertices."""
        return Level.of(subdivide_faces(self.F, self.edge_of, self.n), self.n + len(self.edges))


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
