"""The mesh while it is decimated: half-edges in flat arrays.

Half-edge h = 3 f + k of face f runs from `corner[h]` to `corner[next(h)]`; `opposite[h]` is h itself on the border;
`out[v]` is a half-edge that leaves v, the one on the border if v is on the border (so that turning counter-clockwise
from it meets every face). Face numbers outlive a collapse: a face is dead or the same face, deformed.
"""
from typing import NamedTuple

import numpy as np

from ..geometry import next_halfedge, prev_halfedge
from ..jit import compiled


class HalfedgeMesh(NamedTuple):
    """Half-edge mesh: X (n, 3) positions, corner/opposite/edge (3 m,), out and valence (n,), start (e,): one half-edge
    of each edge."""

    X: np.ndarray
    corner: np.ndarray
    opposite: np.ndarray
    edge: np.ndarray
    out: np.ndarray
    valence: np.ndarray
    start: np.ndarray


@compiled(allocates=True)
def opposites(corner, n):
    """Opposite half-edges (3 m,) int32, itself on the border, and whether no two half-edges have the same two ends in the
    same order; if two have, the first do not count."""
    h_count = len(corner)
    opposite = np.empty(h_count, np.int32)
    at = np.zeros(n + 1, np.int32)
    for h in range(h_count):
        at[corner[h] + 1] += 1
    for v in range(n):
        at[v + 1] += at[v]
    leaving, free = np.empty(h_count, np.int32), at[:n].copy()  # half-edges by their start
    for h in range(h_count):
        leaving[free[corner[h]]] = h
        free[corner[h]] += 1
    owner, to = np.full(n, -1, np.int32), np.empty(n, np.int32)  # by their end
    for v in range(n):
        for k in range(at[v], at[v + 1]):
            w = corner[next_halfedge(leaving[k])]
            if owner[w] == v:
                return opposite, False
            owner[w], to[w] = v, leaving[k]
        for k in range(at[v], at[v + 1]):
            p = prev_halfedge(leaving[k])
            w = corner[p]
            opposite[p] = to[w] if owner[w] == v else p
    return opposite, True


@compiled(allocates=True)
def connect_halfedges(corner, opposite, n):
    """The arrays edge, start, out and valence of a `HalfedgeMesh`, and the number of vertices whose faces do not form one fan.

    corner, opposite (3 m,) int32: see the module; n: number of vertices. The half-edges of an edge are those that are opposite
    to each other; edge (3 m,) numbers them by their first one, start (e,).

    >>> import numpy as np
    >>> from npm_blender.core.decimation import connect_halfedges
    >>> from npm_blender.core.mesh import opposite_halfedges
    >>> F = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    >>> edge, start, out, valence, pinched = connect_halfedges(F.reshape(-1), opposite_halfedges(F).astype(np.int32), 4)
    >>> edge.tolist(), valence.tolist(), int(pinched)  # five edges, the diagonal is number 2; faces at each vertex
    ([0, 1, 2, 2, 3, 4], [2, 1, 2, 1], 0)
    """
    h_count = len(corner)
    edge = np.full(h_count, -1, np.int32)
    start = np.empty(h_count, np.int32)
    out = np.full(n, -1, np.int32)
    valence = np.zeros(n, np.int32)
    e = 0
    for h in range(h_count):
        v = corner[h]
        valence[v] += 1
        if out[v] < 0 or opposite[h] == h:
            out[v] = h
        if edge[h] < 0:
            edge[h] = e
            edge[opposite[h]] = e
            start[e] = h
            e += 1
    pinched = 0
    for v in range(n):
        if out[v] < 0:
            continue
        h, count = out[v], 0
        while True:
            count += 1
            p = prev_halfedge(h)
            h = opposite[p]
            if h == p or h == out[v] or count > valence[v]:
                break
        if count != valence[v]:
            pinched += 1
    return edge, start[:e].copy(), out, valence, pinched


@compiled(inline="always")
def is_border(m, v):
    """Whether vertex v of a HalfedgeMesh is on the border: then the half-edge that leaves it first is.

    >>> from npm_blender.core.decimation import half_edges_with_quadrics, is_border
    >>> from npm_blender.core.mesh import TriMesh
    >>> m, _ = half_edges_with_quadrics(TriMesh.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    >>> bool(is_border(m, 0))
    True
    """
    return m.opposite[m.out[v]] == m.out[v]
