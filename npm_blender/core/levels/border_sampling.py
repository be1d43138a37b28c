"""The border of the finest level on the input's: its vertices slide along the loop to where the polyline is longest.

Between two base vertices the map puts the vertices of the levels somewhere on the loop, seldom on its corners, and a
polyline that cuts corners is shorter than the loop. Each vertex may take a vertex of the input between the ends of its
base edge; the best choice for all vertices of the base edge together is found by dynamic programming.
"""
import numpy as np

from ..geometry import next_halfedge
from ..jit import compiled
from ..mesh import Level, TriMesh

STAY = 1e-3  # price of sliding, in lengths of the polyline for each length slid: a straight border stays as it is
MOST = 4000  # places tried, over the root of the number of vertices inside a base edge: the time grows with its square
GAP = 0.1  # least distance of neighbours along the loop, in shares of the least before


def _next_on_border(F: np.ndarray, opposite: np.ndarray, n: int) -> np.ndarray:
    """The half-edge (n,) int64 that leaves each vertex along the border, or -1."""
    out = np.full(n, -1, np.int64)
    h = np.flatnonzero(opposite == np.arange(F.size))
    out[F.reshape(-1)[h]] = h
    return out


def _halfedge_points(F: np.ndarray, out: np.ndarray, opposite: np.ndarray, face: np.ndarray,
                     b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points of the border, (face, b), as a border half-edge (k,) and a share 0..1 of its length; -1 where there is none."""
    half, share = np.full(len(face), -1, np.int64), np.zeros(len(face))
    for s in range(3):
        h = 3 * face.astype(np.int64) + s
        here = (half < 0) & (opposite[h] == h) & (b[:, (s + 2) % 3] == 0) & (b[:, (s + 1) % 3] < 1)
        half[here], share[here] = h[here], b[here, (s + 1) % 3]
    for s in range(3):
        here = (half < 0) & (b[:, s] == 1)
        half[here] = out[F[face[here], s]]
    return half, share


@compiled
def _choose(X, at, own, gap, room, best, back):
    """Candidates (k,) for the vertices inside one base edge, the longest polyline; X (c, 3), at (c,): the candidates.

    The first candidate is the start, the last one the end of the edge; own (k,): where along the loop each vertex lies;
    best, back (k + 1, c): work space.
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
        room[j - 1] = q


@compiled
def _distance(X, p, q):
    return np.sqrt((X[p, 0] - X[q, 0]) ** 2 + (X[p, 1] - X[q, 1]) ** 2 + (X[p, 2] - X[q, 2]) ** 2)


@compiled(allocates=True)
def _candidates(V, corner, out, half, share, chain, place):
    """Where the vertices of a base edge may go along the input's border, in the order in which that lies there.

    chain (k + 2,): the vertices of the base edge, ends first and last; half, share: where these are (see
    `_halfedge_points`); place (3 m,): -1, work space. Candidates are the ends, the input's vertices between, spread evenly where
    there are too many, and the vertices' own places. Returns their half-edges and shares (c,), positions (c, 3) and places along
    the border (c,), and the vertices' own places (k,); no candidates where the vertices do not follow each other on the loop.
    """
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
    X, at, own = np.empty((inner + k, 3)), np.empty(inner + k), np.empty(k)
    for q in range(inner + k):
        i, j = corner[halves[q]], corner[next_halfedge(halves[q])]
        for c in range(3):
            X[q, c] = V[i, c] + shares[q] * (V[j, c] - V[i, c])
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
    chosen, count = np.empty(inner + k, np.int64), 0
    if follows and at[inner - 1] > before:
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
    chosen = chosen[:count]
    return halves[chosen], shares[chosen], X[chosen], at[chosen], own


@compiled(allocates=True)
def _slide(V, corner, out, fine_corner, fine_out, bases, count, half, share, face, b):
    """Slide the `count` vertices inside each base edge that leaves a vertex of bases (e,) along the border."""
    place, room, chain = np.full(len(corner), -1, np.int64), np.zeros(count, np.int64), np.empty(count + 2, np.int64)
    for v in bases:
        chain[0], whole = v, half[v] >= 0
        for k in range(count + 1):
            chain[k + 1] = fine_corner[next_halfedge(fine_out[chain[k]])]
            whole = whole and half[chain[k + 1]] >= 0
        if not whole:
            continue
        halves, shares, X, at, own = _candidates(V, corner, out, half, share, chain, place)
        if len(halves) == 0:
            continue
        gap = min(own[0], at[-1] - own[-1])
        for k in range(1, count):
            gap = min(gap, own[k] - own[k - 1])
        _choose(X, at, own, GAP * gap, room, np.empty((count + 1, len(at))), np.zeros((count + 1, len(at)), np.int64))
        for k in range(count):
            p, h, t = chain[1 + k], halves[room[k]], shares[room[k]]
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
    V, F = mesh.V, mesh.F
    fine_out = _next_on_border(finest.F, finest.opposite, finest.n)
    if len(levels) < 2 or (fine_out < 0).all():
        return
    out = _next_on_border(F, opposite, len(V))
    border = np.flatnonzero(fine_out >= 0)
    half, share = np.full(finest.n, -1, np.int64), np.zeros(finest.n)
    half[border], share[border] = _halfedge_points(F, out, opposite, face[border], b[border])
    corner, fine_corner = F.reshape(-1), finest.F.reshape(-1)
    _slide(V, corner, out, fine_corner, fine_out, border[border < n0], 2 ** (len(levels) - 1) - 1, half, share, face, b)
