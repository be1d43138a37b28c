"""The border of the finest level on the input's: its vertices slide along the loop to where the polyline is longest.

Between two base vertices the map puts the vertices of the levels somewhere on the loop, seldom on its corners, and a
polyline that cuts corners is shorter than the loop. Each vertex may take a vertex of the input between the ends of its
base edge; the best choice for all vertices of the base edge together is found by dynamic programming.
"""
import numpy as np

from .jit import compiled
from .mesh import TriMesh
from .subdivide import Level

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


def _few(count: int, vertices: int) -> np.ndarray:
    """Which of `count` candidates are tried, (count,) bool: all, or MOST / sqrt(vertices) spread evenly, first and last too."""
    keep = np.zeros(count, bool)
    keep[:: -(-count // int(MOST / vertices**0.5))] = True
    keep[-1] = True
    return keep


@compiled
def _choose(X, at, own, gap, room, best, back):
    """Candidates (k,) for the vertices inside one base edge, the longest polyline; X (c, 3), at (c,): the candidates.

    The first candidate is the start, the last one the end of the edge; own (k,): where along the loop each vertex lies;
    best, back (k + 1, c): work space.
    """
    count, k = len(at), len(own)
    best[:, :] = -np.inf
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


def _loop(V: np.ndarray, F: np.ndarray, out: np.ndarray, start: int, share: float, end: int,
          last: float) -> tuple[np.ndarray, np.ndarray]:
    """Border half-edges (c,) and shares (c,) of the start, of the input's vertices between, and of the end."""
    corner = F.reshape(-1)
    halves, h = [start], start
    while h != end or len(halves) == 1 and last <= share:
        h = out[corner[h - h % 3 + (h + 1) % 3]]
        halves.append(h)
        if len(halves) > len(corner):
            break
    shares = np.zeros(len(halves) + 1)
    shares[0], shares[-1] = share, last
    return np.array([*halves, end]), shares


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
    count = 2 ** (len(levels) - 1) - 1
    room = np.zeros(count, np.int64)
    for v in border[border < n0]:
        chain = [v]
        for _ in range(count + 1):
            h = fine_out[chain[-1]]
            chain.append(fine_corner[h - h % 3 + (h + 1) % 3])
        chain = np.array(chain)
        if (half[chain] < 0).any():
            continue
        halves, shares = _loop(V, F, out, half[v], share[v], half[chain[-1]], share[chain[-1]])
        # the vertices' own places are candidates as well
        halves, shares = np.concatenate([halves, half[chain[1:-1]]]), np.concatenate([shares, share[chain[1:-1]]])
        a, c = V[corner[halves]], V[corner[halves - halves % 3 + (halves + 1) % 3]]
        X = a + shares[:, None] * (c - a)
        # places along the loop: whole half-edges before it, then the share of its own
        inner = len(halves) - count
        ends = np.linalg.norm(np.diff(X[:inner], axis=0), axis=1)
        along = np.concatenate([[0.0], np.cumsum(ends)])
        where = {h: k for k, h in reversed(list(enumerate(halves[:inner - 1])))}
        if any(h not in where for h in halves[inner:]):
            continue
        k = np.array([where[h] for h in halves[inner:]])
        own = along[k] + np.linalg.norm(X[inner:] - X[k], axis=1)
        places = np.concatenate([[0.0], own, along[-1:]])
        steps = np.diff(places)
        if not (steps > 0).all():
            continue
        at = np.concatenate([along, own])
        order = np.argsort(at, kind="stable")
        order = np.concatenate([[0], order[(order != 0) & (order != inner - 1)], [inner - 1]])
        order = order[_few(len(order), count) | (order >= inner)]
        _choose(X[order], at[order], own, GAP * steps.min(), room,
                np.empty((count + 1, len(order))), np.zeros((count + 1, len(order)), np.int64))
        chosen = order[room]
        inside, h, t = chain[1:-1], halves[chosen], shares[chosen]
        face[inside] = h // 3
        b[inside] = 0.0
        b[inside, h % 3] = 1 - t
        b[inside, (h + 1) % 3] = t
