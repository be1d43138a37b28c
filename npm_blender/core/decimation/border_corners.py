"""How many corners of an open border each edge of the base may stand for.

A base edge on the border becomes SEGMENTS edges of the finest level, and a polyline of so many follows a loop only where
it has few corners. So the vertices that a border loop cannot do without are marked before decimation, every border edge
counts those that have vanished into it, and a collapse that would put too many into one edge is refused (see
`collapse_loop`). Where the faces asked for cannot be reached like this, more are allowed.
"""
from typing import NamedTuple

import numpy as np

from ..geometry import next_halfedge, prev_halfedge
from ..jit import compiled
from .edge_heap import DEAD, heapify_edges, put_edge, take_edge
from .halfedge_mesh import HalfedgeMesh

SEGMENTS = 8  # edges of the finest level along a base edge, at three levels
LOSS = 0.005  # share of a loop's length that its unmarked vertices make up together
SHARE = 0.42  # of the base's faces: border edges that the corners may ask for; a quarter left lattices 5 % short
SLACK = 1.25  # least factor by which the allowed number grows
ALLOWED, REFUSED = range(2)  # entries of `Corners.limits`


class Corners(NamedTuple):
    """at (n,) int32: the corner of its border loop that a vertex is, by the number that it had at first, or -1; count (e,)
    int32: corners that have vanished into a border edge; first (e,) int32: one of them, next (n,) int32: another one of the
    same edge, or -1; share (n,) float64: where the map has them on it, 0 at its start to 1; limits (2,): how many are ALLOWED
    on an edge, and the least number, over the collapses REFUSED since the last time more were allowed, that would have let one
    pass.

    met (k,) int32 and place (k,) float64, at least as long as there are corners: those that a collapse meets, and where on
    the line through its stencil (see `flatten_jointly`: 0 at i, 1 at j), met_count (1,): how many; work space.
    """

    at: np.ndarray
    count: np.ndarray  # type: ignore[assignment]  # a field, which hides tuple.count
    first: np.ndarray
    next: np.ndarray
    share: np.ndarray
    limits: np.ndarray
    met: np.ndarray
    place: np.ndarray
    met_count: np.ndarray

    @staticmethod
    def of(halfedges: HalfedgeMesh, base_faces: int) -> "Corners":
        """The corners of a mesh not decimated yet, and how many an edge may take so that base_faces suffice for them."""
        marked = np.zeros(len(halfedges.X), bool)
        border = np.flatnonzero(halfedges.opposite == np.arange(len(halfedges.opposite)))
        if len(border):
            _mark(halfedges.X, halfedges.corner, halfedges.out, border, LOSS, marked)
        most = max(SEGMENTS - 1.0, marked.sum() / max(SHARE * base_faces, 1.0))
        n, edges, room = len(marked), len(halfedges.start) if len(border) else 0, int(marked.sum())
        at = np.where(marked, np.arange(n), -1).astype(np.int32)
        return Corners(at, np.zeros(edges, np.int32), np.full(edges, -1, np.int32), np.full(n, -1, np.int32), np.zeros(n),
                       np.array([most, np.inf]), np.empty(room, np.int32), np.empty(room), np.zeros(1, np.int64))

    @property
    def marked(self) -> np.ndarray:
        """Whether each vertex is a corner, (n,) bool."""
        return self.at >= 0

    def yield_to(self) -> bool:
        """Allow more corners an edge, so that a refused collapse passes; whether there was one."""
        most, refused = self.limits
        if refused == np.inf:
            return False
        self.limits[:] = max(refused, SLACK * most), np.inf
        return True


@compiled
def _price(X, a, b, c):
    """Length that a polyline loses with its vertex b between a and c."""
    total = 0.0
    for p, q, sign in ((a, b, 1.0), (b, c, 1.0), (a, c, -1.0)):
        d0, d1, d2 = X[q, 0] - X[p, 0], X[q, 1] - X[p, 1], X[q, 2] - X[p, 2]
        total += sign * np.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
    return total


@compiled(allocates=True)
def _mark(X, corner, out, border, loss, marked):
    """Mark what is left of each loop when the cheapest vertices are taken out, one after the other, to `loss` of its length.

    border (k,): the border half-edges.
    """
    k = len(border)
    loop = np.empty(k, np.int64)
    before, after = np.empty(k, np.int64), np.empty(k, np.int64)
    heap, price, place = np.empty(k, np.int32), np.empty(k), np.full(k, DEAD, np.int32)
    seen = np.zeros(len(marked), np.bool_)
    for first in border:
        if seen[corner[first]]:
            continue
        n, h, length = 0, first, 0.0
        while not seen[corner[h]]:
            loop[n] = corner[h]
            seen[corner[h]] = True
            h = out[corner[next_halfedge(h)]]
            n += 1
        for q in range(n):
            before[q], after[q], heap[q] = q - 1 if q else n - 1, q + 1 if q + 1 < n else 0, q
        for q in range(n):
            a, b, c = loop[before[q]], loop[q], loop[after[q]]
            price[q] = _price(X, a, b, c)
            length += np.sqrt((X[a, 0] - X[b, 0]) ** 2 + (X[a, 1] - X[b, 1]) ** 2 + (X[a, 2] - X[b, 2]) ** 2)
        heapify_edges(heap, price, place, n)
        room, size = loss * length, n
        while size > 3 and price[0] <= room:
            q = heap[0]
            room -= price[0]
            size = take_edge(heap, price, place, q, DEAD, size)
            a, c = before[q], after[q]
            after[a], before[c] = c, a
            size = put_edge(heap, price, place, a, _price(X, loop[before[a]], loop[a], loop[c]), size)
            size = put_edge(heap, price, place, c, _price(X, loop[a], loop[c], loop[after[c]]), size)
        for q in range(size):
            marked[loop[heap[q]]] = True


@compiled
def edge_before(m, i):
    """The edge that arrives at a vertex of the border along it."""
    h = m.out[i]
    while True:
        p = prev_halfedge(h)
        h = m.opposite[p]
        if h == p:
            return m.edge[p]


@compiled
def _meet(corners, e, start, end, met):
    """Add the corners inside edge e, which lies from `start` to `end` on the line; returns how many there are now."""
    v = corners.first[e]
    while v >= 0:
        corners.met[met], corners.place[met] = v, start + corners.share[v] * (end - start)
        met += 1
        v = corners.next[v]
    return met


@compiled
def corners_round(m, corners, h, before, at, after):
    """Note the corners inside the border edges that border half-edge h: i -> j and its neighbours become, when it shrinks to a
    vertex at place `at` of the line on which i is at 0 and j at 1; before, after: the places of the neighbours of i and j.

    Returns the border edges before i and after j; how many corners come to lie in the edge before that vertex and in the one
    after it; and the corner that the vertex is, or -1. An edge that keeps its place (at = 0: the one before, at = 1: the one
    after) keeps its corners, and they are not noted.
    """
    i, j = m.corner[h], m.corner[next_halfedge(h)]
    met, left, right, corner = 0, 0, 0, -1
    previous, later = edge_before(m, i), m.edge[m.out[j]]
    if at > 0.0:
        met = _meet(corners, previous, before, 0.0, met)
    else:
        left = corners.count[previous]
    met = _meet(corners, m.edge[h], 0.0, 1.0, met)
    if at < 1.0:
        met = _meet(corners, later, 1.0, after, met)
    else:
        right = corners.count[later]
    for v, place in ((i, 0.0), (j, 1.0)):
        if corners.at[v] >= 0:
            if place == at:
                corner = corners.at[v]
            else:
                corners.met[met], corners.place[met] = corners.at[v], place
                met += 1
    corners.met_count[0] = met
    for k in range(met):
        if corners.place[k] < at:
            left += 1
        else:
            right += 1
    return previous, later, left, right, corner


@compiled
def put_corners(m, corners, i, previous, later, before, at, after, corner):
    """Put the corners that `corners_round` noted into the edges before and after vertex i, to which the edge has shrunk.

    previous, later: the edges there before it shrunk, other ones where an ear vanished; corner: that at i, or -1.
    """
    left, right = edge_before(m, i), m.edge[m.out[i]]
    corners.first[left], corners.count[left] = corners.first[previous], corners.count[previous]
    corners.first[right], corners.count[right] = corners.first[later], corners.count[later]
    if at > 0.0:
        corners.first[left], corners.count[left] = -1, 0
    if at < 1.0:
        corners.first[right], corners.count[right] = -1, 0
    for k in range(corners.met_count[0]):
        v, place = corners.met[k], corners.place[k]
        e = left if place < at else right
        corners.share[v] = (place - before) / (at - before) if place < at else (place - at) / (after - at)
        corners.next[v], corners.first[e] = corners.first[e], v
        corners.count[e] += 1
    corners.at[i] = corner
