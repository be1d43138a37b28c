"""The border of the finest level on the input's: its vertices slide along the loop to where the polyline is longest.

Between two base vertices the map puts the vertices of the levels somewhere on the loop, seldom on its corners, and a polyline
that cuts corners is shorter than the loop. Each vertex may take a vertex of the input between the ends of its base edge; the
best choice for all k vertices of the base edge together is found by dynamic programming over the candidates q, with positions
X_q and places s_q along the loop, the first and last of which are the ends of the base edge:

    best_0(0) = 0,    best_j(q) = max over p < q with s_q - s_p >= gap of  best_(j-1)(p) + |X_q - X_p| - STAY |s_q - own_j|

where own_j is the place of vertex j of 1..k on the loop as the map puts it, and the last price falls away at the end of the edge,
j = k + 1. The polyline best_(k+1)(last) is the longest, less the price of sliding. The method is ours.
"""
from typing import NamedTuple

import numpy as np

from ..geometry import next_halfedge
from ..jit import compiled
from ..mesh import Level, TriMesh

STAY = 1e-3  # price of sliding, in lengths of the polyline for each length slid: a straight border stays as it is
MOST = 4000  # places tried, over the root of the number of vertices inside a base edge: the time grows with its square
GAP = 0.1  # least distance of neighbours along the loop, in shares of the least before


class Border(NamedTuple):
    """The border of a mesh: corner (3 m,) int32: the vertex at the start of each half-edge; out (n,) int64: the half-edge that
    leaves each vertex along the border, or -1."""

    corner: np.ndarray
    out: np.ndarray


class BorderPoints(NamedTuple):
    """Points of a border: halfedge (k,) int64, of the border, or -1, and share (k,) float64, 0..1 of its length."""

    halfedge: np.ndarray
    share: np.ndarray


class Candidates(NamedTuple):
    """Where the vertices of a base edge may go, in the order in which that lies along the border, both ends included: halfedge
    and share (c,) as in BorderPoints, position X (c, 3) and place `at` along the border (c,), from the start of the base edge on;
    own (k,): the places of the vertices inside now."""

    halfedge: np.ndarray
    share: np.ndarray
    X: np.ndarray
    at: np.ndarray
    own: np.ndarray


def _border_of(F: np.ndarray, opposite: np.ndarray, n: int) -> Border:
    """The border of n vertices and faces F (m, 3); opposite (3 m,): opposite half-edges."""
    out = np.full(n, -1, np.int64)
    h = np.flatnonzero(opposite == np.arange(F.size))
    out[F.reshape(-1)[h]] = h
    return Border(F.reshape(-1), out)


def _on_border(border: Border, opposite: np.ndarray, face: np.ndarray, b: np.ndarray) -> BorderPoints:
    """Points (face (k,), barycentrics b (k, 3)) as points of the border; halfedge is -1 where one is not on it."""
    half, share = np.full(len(face), -1, np.int64), np.zeros(len(face))
    for s in range(3):
        h = 3 * face.astype(np.int64) + s
        here = (half < 0) & (opposite[h] == h) & (b[:, (s + 2) % 3] == 0) & (b[:, (s + 1) % 3] < 1)
        half[here], share[here] = h[here], b[here, (s + 1) % 3]
    for s in range(3):
        here = (half < 0) & (b[:, s] == 1)
        half[here] = border.out[border.corner[3 * face[here].astype(np.int64) + s]]
    return BorderPoints(half, share)


@compiled
def _choose(X, at, own, gap, chosen, best, back):
    """Candidates, chosen (k,), for the vertices inside one base edge, which make the longest polyline: see the module.

    X (c, 3), at (c,), own (k,): see Candidates; gap: least distance of neighbours along the border; best, back (k + 1, c): work
    space: the length up to vertex j + 1 if that is at a candidate, and the candidate of the vertex before.
    """
    count, k = len(at), len(own)
    for j in range(k + 1):
        for q in range(count):
            best[j, q] = -np.inf
    for j in range(k + 1):
        for q in range(1, count):
            if (q == count - 1) != (j == k):
                continue
            for p in range(q):
                if (p > 0) != (j > 0) or at[q] - at[p] < gap:
                    continue
                before = 0.0 if j == 0 else best[j - 1, p]
                if before == -np.inf:
                    continue
                d0, d1, d2 = X[q, 0] - X[p, 0], X[q, 1] - X[p, 1], X[q, 2] - X[p, 2]
                total = before + np.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
                if j < k:
                    total -= STAY * abs(at[q] - own[j])
                if total > best[j, q]:
                    best[j, q], back[j, q] = total, p
    q = count - 1
    for j in range(k, 0, -1):
        q = back[j, q]
        chosen[j - 1] = q


@compiled
def _distance(X, p, q):
    return np.sqrt((X[p, 0] - X[q, 0]) ** 2 + (X[p, 1] - X[q, 1]) ** 2 + (X[p, 2] - X[q, 2]) ** 2)


@compiled(allocates=True)
def _points_between(border, points, chain):
    """Half-edges and shares of the ends of a base edge and the input's vertices between, in their order, then of the vertices
    inside the base edge; and how many the first are. Arguments: see `_candidates`."""
    corner, out, half, share = border.corner, border.out, points.halfedge, points.share
    k, start, end, last = len(chain) - 2, half[chain[0]], half[chain[-1]], share[chain[-1]]
    h, inner = start, 2
    while (h != end or (inner == 2 and last <= share[chain[0]])) and inner <= len(corner):
        h = out[corner[next_halfedge(h)]]
        inner += 1
    halves, shares = np.empty(inner + k, np.int64), np.zeros(inner + k)
    h = start
    for q in range(inner - 1):
        halves[q] = h
        h = out[corner[next_halfedge(h)]]
    halves[inner - 1], shares[0], shares[inner - 1] = end, share[chain[0]], last
    for j in range(k):
        halves[inner + j], shares[inner + j] = half[chain[1 + j]], share[chain[1 + j]]
    return halves, shares, inner


@compiled
def _measure(halves, X, at, own, place):
    """Places along the border, at (inner + k,), of the points X of `_points_between`, and own (k,), those of the last k of them.
    place (3 m,): -1, work space. Returns whether the last k follow each other inside the base edge."""
    k = len(own)
    inner = len(at) - k
    at[0] = 0.0
    for q in range(1, inner):
        at[q] = at[q - 1] + _distance(X, q, q - 1)
    for q in range(inner - 2, -1, -1):
        place[halves[q]] = q
    follows, before = True, 0.0
    for j in range(k):
        q = place[halves[inner + j]]
        follows = follows and q >= 0
        if follows:
            own[j] = at[inner + j] = at[q] + _distance(X, inner + j, q)
            follows = own[j] > before
            before = own[j]
    for q in range(inner - 1):
        place[halves[q]] = -1
    return follows and at[inner - 1] > before


@compiled
def _merge(at, own, chosen):
    """Numbers of the points of `_points_between` that become candidates, in the order of their places `at`, in chosen;
    returns how many: all places of vertices, own (k,), both ends, and of the rest one in so many that MOST is kept."""
    k = len(own)
    inner, count = len(at) - k, 0
    stride, q, j = -(-(inner + k) // int(MOST / k**0.5)), 0, 0
    for n in range(inner + k):  # both lists are in order
        if q < inner - 1 and (j == k or at[q] <= own[j] or q == 0):
            take, number = n % stride == 0, q
            q += 1
        elif j < k:
            take, number = True, inner + j
            j += 1
        else:
            take, number = True, inner - 1
        if take:
            chosen[count] = number
            count += 1
    return count


@compiled(allocates=True)
def _candidates(V, border, points, chain, place):
    """Where the vertices of a base edge may go along the input's border.

    V (n, 3), border: of the input; chain (k + 2,): the vertices of the base edge, ends first and last; points: where these
    are; place (3 m,): -1, work space. Candidates are the ends, the input's vertices between, spread evenly where there are
    too many, and the vertices' own places; none where the vertices do not follow each other on the loop.
    """
    corner, k = border.corner, len(chain) - 2
    halves, shares, inner = _points_between(border, points, chain)
    X, at, own = np.empty((inner + k, 3)), np.empty(inner + k), np.empty(k)
    for q in range(inner + k):
        i, j = corner[halves[q]], corner[next_halfedge(halves[q])]
        for c in range(3):
            X[q, c] = V[i, c] + shares[q] * (V[j, c] - V[i, c])
    chosen, count = np.empty(inner + k, np.int64), 0
    if _measure(halves, X, at, own, place):
        count = _merge(at, own, chosen)
    chosen = chosen[:count]
    return Candidates(halves[chosen], shares[chosen], X[chosen], at[chosen], own)


@compiled(allocates=True)
def _slide(V, border, fine, bases, count, points, face, b):
    """Slide the `count` vertices inside each base edge that leaves a vertex of bases (e,) along the border.

    V, border: of the input; fine: the Border of the finest level; points: where its vertices are; face (n,), b (n, 3) change.
    """
    place, chain = np.full(len(border.corner), -1, np.int64), np.empty(count + 2, np.int64)
    chosen, half = np.zeros(count, np.int64), points.halfedge
    for v in bases:
        chain[0], whole = v, half[v] >= 0
        for k in range(count + 1):
            chain[k + 1] = fine.corner[next_halfedge(fine.out[chain[k]])]
            whole = whole and half[chain[k + 1]] >= 0
        if not whole:
            continue
        to = _candidates(V, border, points, chain, place)
        at, own = to.at, to.own
        if len(at) == 0:
            continue
        gap = min(own[0], at[-1] - own[-1])
        for k in range(1, count):
            gap = min(gap, own[k] - own[k - 1])
        _choose(to.X, at, own, GAP * gap, chosen, np.empty((count + 1, len(at))), np.zeros((count + 1, len(at)), np.int64))
        for k in range(count):
            p, h, t = chain[1 + k], to.halfedge[chosen[k]], to.share[chosen[k]]
            face[p] = h // 3
            b[p, 0] = b[p, 1] = b[p, 2] = 0.0
            b[p, h % 3], b[p, (h + 1) % 3] = 1.0 - t, t


def follow_border(mesh: TriMesh, opposite: np.ndarray, levels: list[Level], face: np.ndarray,
                  b: np.ndarray) -> None:
    """Slide the border vertices of the finest of `levels` along the input's border, in place: face (n,), b (n, 3).

    opposite (3 m,): opposite half-edges of the mesh. Base vertices stay. A base edge whose vertices do not follow each
    other on the loop is left as it is.
    """
    finest, n0 = levels[-1], levels[0].n
    fine = _border_of(finest.F, finest.opposite, finest.n)
    if len(levels) < 2 or (fine.out < 0).all():
        return
    border = _border_of(mesh.F, opposite, len(mesh.V))
    on = np.flatnonzero(fine.out >= 0)
    points = BorderPoints(np.full(finest.n, -1, np.int64), np.zeros(finest.n))
    points.halfedge[on], points.share[on] = _on_border(border, opposite, face[on], b[on])
    _slide(mesh.V, border, fine, on[on < n0], 2 ** (len(levels) - 1) - 1, points, face, b)
