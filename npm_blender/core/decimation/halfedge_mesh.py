"""The mesh while it is decimated: half-edges in flat arrays, the patch round an edge, and the collapse itself.

Half-edge h = 3 f + k of face f runs from `corner[h]` to `corner[next(h)]`; `opposite[h]` is h itself on the border;
`out[v]` is a half-edge that leaves v, the one on the border if v is on the border (so that turning counter-clockwise
from it meets every face). Face numbers outlive a collapse: a face is dead or the same face, deformed.

The patch of a collapse i, j -> i is the ring of vertices round the edge, counter-clockwise, with one face per ring
side. Ring faces s1..s2-1 belong to j, the others to i; besides them there are the two faces on the edge,
(i, j, ring[s2]) and (j, i, ring[s1]), which vanish. INNER: both ends inside, closed ring, s1 = 0. ANCHORED: i on the
border, open ring. EDGE: the edge is on the border; open ring, s1 = 0, only the first of the two faces.
"""
from typing import NamedTuple

import numpy as np

from ..geometry import next_halfedge, prev_halfedge
from ..jit import compiled
from ..parameterization import ANCHORED, EDGE, INNER


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
    """edge, start, out and valence of the mesh, and the number of vertices whose faces do not form one fan."""
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
    """Whether vertex v is on the border."""
    return m.opposite[m.out[v]] == m.out[v]


@compiled
def _fan(m, h, stop, ring, face, r, t):
    """Append the faces round the start of h, counter-clockwise, until the half-edge `stop` or the border."""
    while h != stop:
        ring[r] = m.corner[next_halfedge(h)]
        face[t] = h // 3 * 4 + h % 3
        r += 1
        t += 1
        p = prev_halfedge(h)
        h = m.opposite[p]
        if h == p:
            ring[r] = m.corner[p]
            r += 1
            break
    return r, t


@compiled(inline="always")
def gather_stencil(m, h, kind, ring, face):
    """Fill ring (vertices) and face (4 * face + corner of the owner) of the collapse along h: i -> j.

    Returns (r, t, s1, s2): ring vertices, ring faces, and the range of those that j owns. The vanishing faces follow
    the ring faces in `face`: 4 f + corner of i, then (not for EDGE) 4 f + corner of j.
    """
    o = m.opposite[h]
    r = t = s1 = 0
    if kind == INNER:
        r, t = _fan(m, m.opposite[prev_halfedge(o)], next_halfedge(h), ring, face, r, t)
        s2 = r
        r, t = _fan(m, m.opposite[prev_halfedge(h)], next_halfedge(o), ring, face, r, t)
    else:
        if kind == ANCHORED:
            r, t = _fan(m, m.out[m.corner[h]], next_halfedge(o), ring, face, r, t)
            s1 = r
            r, t = _fan(m, m.opposite[prev_halfedge(o)], next_halfedge(h), ring, face, r, t)
        else:
            r, t = _fan(m, m.out[m.corner[o] if o != h else m.corner[next_halfedge(h)]], next_halfedge(h), ring, face, r, t)
        s2 = r
        p = prev_halfedge(h)
        if m.opposite[p] == p:
            ring[r] = m.corner[p]
            r += 1
        else:
            r, t = _fan(m, m.opposite[p], -1, ring, face, r, t)
    face[t] = h // 3 * 4 + h % 3
    if kind != EDGE:
        face[t + 1] = o // 3 * 4 + o % 3
    return r, t, s1, s2


@compiled(inline="always")
def link_condition_holds(ring, r, s1, s2):
    """Whether no vertex comes twice in the ring: i and j have no neighbour in common but those of both faces on the edge
    (the link condition)."""
    for q in range(s1, min(s2 + 1, r)):
        for p in range(r):
            if ring[p] == ring[q] and p != q:
                return False
    return True


@compiled
def _stitch(m, gone, kept, v):
    """Close the gap that a vanished face leaves between its sides `gone` (at j) and `kept` (at i).

    v: the third vertex. Returns the edge that vanishes; afterwards the edge of `kept` is the edge i-v.
    """
    x, y = m.opposite[gone], m.opposite[kept]
    e = m.edge[kept]
    inner_x, inner_y = x != gone, y != kept
    if inner_x:
        m.opposite[x] = y if inner_y else x
        m.edge[x] = e
        m.start[e] = x
    if inner_y:
        m.opposite[y] = x if inner_x else y
        m.start[e] = y
    return m.edge[gone]


@compiled
def collapse_edge(m, h, kind, x, y, z, face, t, s1, s2, dead):
    """Collapse along h: i -> j, both become i at (x, y, z); patch as from `gather_stencil`.

    dead (3,): edges that vanish. Returns the number of faces removed.
    """
    o = m.opposite[h]
    i, j = m.corner[h], m.corner[next_halfedge(h)]
    n1, p1 = next_halfedge(h), prev_halfedge(h)
    a = m.corner[p1]
    x1, y1 = m.opposite[n1], m.opposite[p1]
    next_border = m.out[j]
    for q in range(s1, s2):
        m.corner[face[q] // 4 * 3 + face[q] % 4] = i
    dead[0] = m.edge[h]
    dead[1] = _stitch(m, n1, p1, a)
    if m.out[a] == p1:
        m.out[a] = x1
    removed = 1
    if kind == EDGE:
        m.out[i] = y1 if next_border == n1 else next_border
        dead[2] = dead[0]
    else:
        n2, p2 = next_halfedge(o), prev_halfedge(o)
        b = m.corner[p2]
        x2, y2 = m.opposite[p2], m.opposite[n2]
        dead[2] = _stitch(m, p2, n2, b)
        if m.out[b] == p2:
            m.out[b] = y2
        if kind == INNER:
            m.out[i] = y1
        elif m.out[i] == n2:
            m.out[i] = x2
        m.valence[b] -= 1
        for k in range(3):
            m.corner[o // 3 * 3 + k] = -1
        removed = 2
    m.valence[a] -= 1
    for k in range(3):
        m.corner[h // 3 * 3 + k] = -1
    m.valence[i] = t
    m.valence[j] = 0
    m.out[j] = -1
    m.X[i, 0], m.X[i, 1], m.X[i, 2] = x, y, z
    return removed
