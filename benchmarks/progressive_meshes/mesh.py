"""The mesh that grows: half-edges in flat arrays with room for what comes, and the vertex split.

Half-edge h = 3 f + k of face f starts at corner[h]; opposite[h] is h itself on the border; out[v] leaves v, on the border
from the first of its faces counter-clockwise.
"""

from typing import NamedTuple

import numpy as np

from npm_blender.core.decimation import connect_halfedges
from npm_blender.core.geometry import next_halfedge, prev_halfedge
from npm_blender.core.jit import compiled
from npm_blender.core.mesh import opposite_halfedges

MAX_RING = 60  # vertices with more neighbours are not split
VERTICES, FACES = 0, 1  # columns of Growing.counts


class Growing(NamedTuple):
    """X (n, 3), corner and opposite (3 m,), out (n,), valence (n,): faces at a vertex; counts (2,): VERTICES, FACES."""

    X: np.ndarray
    corner: np.ndarray
    opposite: np.ndarray
    out: np.ndarray
    valence: np.ndarray
    counts: np.ndarray

    @staticmethod
    def of(V: np.ndarray, F: np.ndarray, splits: int) -> "Growing":
        """The base mesh V (n, 3), F (m, 3), with room for so many splits."""
        n, m = len(V), len(F)
        X = np.zeros((n + splits, 3))
        X[:n] = V
        corner, opposite = np.full((2, 3 * (m + 2 * splits)), -1, np.int32)
        corner[: 3 * m] = F.reshape(-1)
        opposite[: 3 * m] = opposite_halfedges(F)
        out, valence = np.full(n + splits, -1, np.int32), np.zeros(n + splits, np.int32)
        _, _, first, count, _ = connect_halfedges(corner[: 3 * m], opposite[: 3 * m], n)
        out[:n], valence[:n] = first, count
        return Growing(X, corner, opposite, out, valence, np.array([n, m], np.int64))

    def faces(self) -> np.ndarray:
        """Faces (m, 3) int32 now."""
        return self.corner[: 3 * self.counts[FACES]].reshape(-1, 3).copy()

    def vertices(self) -> np.ndarray:
        """Positions (n, 3) float64 now."""
        return self.X[: self.counts[VERTICES]].copy()


class Site(NamedTuple):
    """Vertex v, its neighbours ring[:count], and the half-edges spoke[:faces] from it into its faces; see ring_of."""

    v: int
    ring: np.ndarray
    spoke: np.ndarray
    count: int
    faces: int
    border: bool


@compiled
def ring_of(m, v, ring, spoke):
    """Neighbours of v, counter-clockwise, and the half-edges from v into the faces between them.

    Returns (neighbours, faces, whether v is on the border): on the border one face less than neighbours.
    """
    h = first = m.out[v]
    k = 0
    while True:
        ring[k], spoke[k] = m.corner[next_halfedge(h)], h
        k += 1
        p = prev_halfedge(h)
        h = m.opposite[p]
        if h == p:
            ring[k] = m.corner[p]
            return k + 1, k, True
        if h == first:
            return k, k, False


@compiled
def _join(m, a, b):
    m.opposite[a] = b
    m.opposite[b] = a


@compiled
def split(m, v, ring, spoke, faces, border, p, q):
    """Split v: the new vertex t takes the faces between neighbours p and q (p < q), or up to q if p is -1.

    p = -1 only on the border: then the edge v-t is on the border too. Returns t.
    """
    t, f = m.counts[VERTICES], m.counts[FACES]
    first = max(p, 0)
    for k in range(first, q):
        m.corner[spoke[k]] = t
    m.valence[v] -= q - first
    m.valence[t] = q - first
    # the open side of an edge from v or t to a neighbour: the half-edge there that needs a partner, -1 outside
    q_into = spoke[q] if q < faces else -1  # v -> ring[q]
    q_back = -1 if q == 0 else prev_halfedge(spoke[q - 1])  # ring[q] -> t
    b0, b1, b2 = 3 * f, 3 * f + 1, 3 * f + 2  # t -> ring[q], ring[q] -> v, v -> t
    m.corner[b0], m.corner[b1], m.corner[b2] = t, ring[q], v
    for h, other in ((b0, q_back), (b1, q_into)):
        if other >= 0:
            _join(m, h, other)
        else:
            m.opposite[h] = h
    f += 1
    m.opposite[b2] = b2
    m.valence[ring[q]] += 1
    if p < 0:
        m.out[t] = spoke[0] if q > 0 else b0
        m.out[v] = b2
    else:
        back = spoke[p - 1] if p > 0 else (-1 if border else spoke[faces - 1])
        p_back = prev_halfedge(back) if back >= 0 else -1  # ring[p] -> v
        a0, a1, a2 = 3 * f, 3 * f + 1, 3 * f + 2  # v -> ring[p], ring[p] -> t, t -> v
        m.corner[a0], m.corner[a1], m.corner[a2] = v, ring[p], t
        if p_back >= 0:
            _join(m, a0, p_back)
        else:
            m.opposite[a0] = a0
        _join(m, a1, spoke[p])
        _join(m, a2, b2)
        f += 1
        m.valence[ring[p]] += 1
        m.valence[v] += 1
        m.valence[t] += 1
        m.out[t] = spoke[p]
        if border:
            m.out[v] = a0 if p == 0 else spoke[0]
        else:
            m.out[v] = b2
    m.valence[v] += 1
    m.valence[t] += 1
    _first_out(m, ring[q])
    if p >= 0:
        _first_out(m, ring[p])
    m.counts[VERTICES], m.counts[FACES] = t + 1, f
    return t


@compiled
def _first_out(m, v):
    """Turn out[v] to the border, if v is on it."""
    h = first = m.out[v]
    while m.opposite[h] != h:
        h = next_halfedge(m.opposite[h])
        if h == first:
            return
    m.out[v] = h
