"""How many corners of an open border each edge of the base may stand for.

A base edge on the border becomes SEGMENTS edges of the finest level, and a polyline of so many follows a loop only where
it has few corners. So the vertices that a border loop cannot do without are marked before decimation, every border edge
counts those that have vanished into it, and a collapse that would put too many into one edge is refused (see
`collapses`). Where the faces asked for cannot be reached like this, more are allowed.
"""
from typing import NamedTuple

import numpy as np

from .edgeheap import DEAD, heapify, put, take
from .halfedge import Half, following, preceding
from .jit import compiled

SEGMENTS = 8  # edges of the finest level along a base edge, at three levels
LOSS = 0.005  # share of a loop's length that its unmarked vertices make up together
SHARE = 0.42  # of the base's faces: border edges that the corners may ask for; a quarter left lattices 5 % short
SLACK = 1.25  # least factor by which the allowed number grows


class Corners(NamedTuple):
    """marked (n,) bool: the vertex is a corner of its border loop; inside (e,) float64: corners that have vanished into
    a border edge, in parts where an end of the edge slid past others; limits (2,): how many there may be, and the least
    number, over the collapses refused since the last time more were allowed, that would have let one pass."""

    marked: np.ndarray
    inside: np.ndarray
    limits: np.ndarray

    @staticmethod
    def of(half: Half, base_faces: int) -> "Corners":
        """The corners of a mesh not decimated yet, and how many an edge may take so that base_faces suffice for them."""
        marked = np.zeros(len(half.X), bool)
        border = np.flatnonzero(half.opposite == np.arange(len(half.opposite)))
        if len(border):
            _mark(half.X, half.corner, half.out, border, LOSS, marked)
        most = max(SEGMENTS - 1.0, marked.sum() / max(SHARE * base_faces, 1.0))
        return Corners(marked, np.zeros(len(half.start)), np.array([most, np.inf]))

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
    heap, place, price = np.empty(k, np.int32), np.full(k, DEAD, np.int32), np.empty(k)
    seen = np.zeros(len(marked), np.bool_)
    for first in border:
        if seen[corner[first]]:
            continue
        n, h, length = 0, first, 0.0
        while not seen[corner[h]]:
            loop[n] = corner[h]
            seen[corner[h]] = True
            h = out[corner[following(h)]]
            n += 1
        for q in range(n):
            before[q], after[q], heap[q] = q - 1 if q else n - 1, q + 1 if q + 1 < n else 0, q
        for q in range(n):
            a, b, c = loop[before[q]], loop[q], loop[after[q]]
            price[q] = _price(X, a, b, c)
            length += np.sqrt((X[a, 0] - X[b, 0]) ** 2 + (X[a, 1] - X[b, 1]) ** 2 + (X[a, 2] - X[b, 2]) ** 2)
        heapify(heap, place, price, n)
        room, size = loss * length, n
        while size > 3 and price[heap[0]] <= room:
            q = heap[0]
            room -= price[q]
            size = take(heap, place, price, q, DEAD, size)
            a, c = before[q], after[q]
            after[a], before[c] = c, a
            size = put(heap, place, price, a, _price(X, loop[before[a]], loop[a], loop[c]), size)
            size = put(heap, place, price, c, _price(X, loop[a], loop[c], loop[after[c]]), size)
        for q in range(size):
            marked[loop[heap[q]]] = True


@compiled
def edge_before(m, i):
    """The edge that arrives at a vertex of the border along it."""
    h = m.out[i]
    while True:
        p = preceding(h)
        h = m.opposite[p]
        if h == p:
            return m.edge[p]


@compiled
def corners_after(m, corners, h, at):
    """Corners inside the border edges before and after the vertex that border half-edge h: i -> j shrinks to.

    at: where on it, 0..1 (see `flatten`: the place of k). Also returns whether the vertex is a corner.
    """
    i, j = m.corner[h], m.corner[following(h)]
    own = corners.inside[m.edge[h]]
    left, right = corners.inside[edge_before(m, i)], corners.inside[m.edge[m.out[j]]]
    i_marked, j_marked = corners.marked[i], corners.marked[j]
    if at < 1e-9:
        return left, right + own + j_marked, i_marked
    if at > 1.0 - 1e-9:
        return left + own + i_marked, right, j_marked
    return left + at * own + i_marked, right + (1.0 - at) * own + j_marked, False
