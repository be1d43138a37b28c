"""Loop and modified Butterfly subdivision as sparse matrices, with borders.

The vertices of a subdivided mesh are those of the `Level` that it comes from, then one per edge: matrices are
(n + e, n) and a mesh subdivided twice is B @ (A @ V). Loop: Loop 1987 with his weights, cubic B-splines on the border.
Butterfly: Zorin, Schroeder and Sweldens 1996; the four-point rule on the border, and where the stencil of an inner edge
reaches beyond the border, the vertex that is missing is the mirror image of the one opposite.
"""

from collections.abc import Callable

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from npm_blender.core.mesh import Level, TriMesh

LEVELS = 3
MOST_FACES = 70_000  # a base too large for three levels gets fewer, but one
WING = -1 / 16


class _Stencils:
    """Entries of a sparse matrix, gathered piece by piece."""

    def __init__(self) -> None:
        self._rows, self._columns, self._values = [], [], []

    def add(self, rows: np.ndarray, columns: np.ndarray, values) -> None:
        """Entries; the same place twice is summed."""
        self._rows.append(rows)
        self._columns.append(columns)
        self._values.append(np.broadcast_to(values, rows.shape).astype(float))

    def matrix(self, rows: int, columns: int) -> csr_matrix:
        """All of them."""
        parts = (np.concatenate(p) for p in (self._values, self._rows, self._columns))
        values, i, j = parts
        return coo_matrix((values, (i, j)), (rows, columns)).tocsr()


class _Star:
    """What the stencils ask of a level: the ends and apexes of edges, borders, valences."""

    def __init__(self, level: Level) -> None:
        self.level, self.n = level, level.n
        self.flat = level.F.reshape(-1)
        self.a, self.b = level.edges.T
        self.h, self.o = level.edge_halfedge.T
        self.rim = self.h == self.o  # edges on the border
        self.valence = np.bincount(level.edges.reshape(-1), minlength=level.n)
        self.on_border = np.bincount(level.edges[self.rim].reshape(-1), minlength=level.n) > 0

    def apex(self, h: np.ndarray) -> np.ndarray:
        """The third vertex of the face of a half-edge."""
        return self.flat[previous(h)]

    def border_ends(self) -> tuple[np.ndarray, np.ndarray]:
        """Every border edge both ways: from, to."""
        a, b = self.a[self.rim], self.b[self.rim]
        return np.concatenate([a, b]), np.concatenate([b, a])


def previous(h: np.ndarray) -> np.ndarray:
    """The half-edge before h in its face."""
    return h - h % 3 + (h + 2) % 3


def following(h: np.ndarray) -> np.ndarray:
    """The half-edge after h in its face."""
    return h - h % 3 + (h + 1) % 3


def _loop_weight(valence: np.ndarray) -> np.ndarray:
    """Loop's weight of each neighbour of an inner vertex."""
    k = np.maximum(valence, 1)
    return (5 / 8 - (3 / 8 + np.cos(2 * np.pi / k) / 4) ** 2) / k


def _around(star: _Star, out: _Stencils, inner: np.ndarray, border: float) -> None:
    """Stencils of vertices: `inner` (n,) for each neighbour of an inner one, `border` for both on the border."""
    near = np.where(star.on_border, 0.0, inner)
    for v, other in ((star.a, star.b), (star.b, star.a)):
        out.add(v, other, near[v])
    v, other = star.border_ends()
    out.add(v, other, border)
    all_vertices = np.arange(star.n)
    count = np.bincount(v, minlength=star.n)
    out.add(all_vertices, all_vertices, 1 - near * star.valence - border * count)


def loop(level: Level) -> csr_matrix:
    """The matrix (n + e, n) of one step of Loop subdivision."""
    star, out = _Star(level), _Stencils()
    _around(star, out, _loop_weight(star.valence), 1 / 8)
    row = star.n + np.arange(len(star.a))
    ends = np.where(star.rim, 1 / 2, 3 / 8)
    out.add(row, star.a, ends)
    out.add(row, star.b, ends)
    inner = ~star.rim
    out.add(row[inner], star.apex(star.h[inner]), 1 / 8)
    out.add(row[inner], star.apex(star.o[inner]), 1 / 8)
    return out.matrix(star.n + len(row), star.n)


def loop_limit(level: Level) -> csr_matrix:
    """The matrix (n, n) that takes the vertices of a level to where repeated Loop subdivision takes them."""
    star, out = _Star(level), _Stencils()
    _around(star, out, 1 / (3 / (8 * _loop_weight(star.valence)) + star.valence), 1 / 6)
    return out.matrix(star.n, star.n)


def butterfly(level: Level) -> csr_matrix:
    """The matrix (n + e, n) of one step of modified Butterfly subdivision; it keeps the vertices that there are."""
    star, out = _Star(level), _Stencils()
    all_vertices = np.arange(star.n)
    out.add(all_vertices, all_vertices, 1.0)
    row = star.n + np.arange(len(star.a))
    _border_edges(star, out, row)
    odd = [(star.valence[v] != 6) & ~star.on_border[v] & ~star.rim for v in (star.a, star.b)]
    share = np.where(odd[0] & odd[1], 1 / 2, 1.0)
    # h runs from the smaller vertex a of an edge to b, its opposite back
    for chosen, start in zip(odd, (star.h, star.o), strict=True):
        _odd_edges(star, out, row[chosen], start[chosen], share[chosen])
    plain = ~star.rim & ~odd[0] & ~odd[1]
    _plain_edges(star, out, row[plain], star.h[plain], star.o[plain])
    return out.matrix(star.n + len(row), star.n)


def _plain_edges(star: _Star, out: _Stencils, row: np.ndarray, h: np.ndarray, o: np.ndarray) -> None:
    """The eight points: ends, apexes, wings."""
    opposite, flat = star.level.opposite, star.flat
    for side in (h, o):
        out.add(row, flat[side], 1 / 2)
        out.add(row, star.apex(side), 1 / 8)
        for far in (following(side), previous(side)):
            beyond = opposite[far]
            there = beyond != far
            out.add(row[there], star.apex(beyond[there]), WING)
            e, r = far[~there], row[~there]  # the mirror image of the apex of `far` in the middle of its edge
            for vertex, sign in ((flat[e], 1), (flat[following(e)], 1), (star.apex(e), -1)):
                out.add(r, vertex, sign * WING)


def _odd_edges(star: _Star, out: _Stencils, row: np.ndarray, h: np.ndarray, share: np.ndarray) -> None:
    """Edges at an inner vertex of another valence than 6, h leaving it: the ring round that vertex."""
    opposite, flat = star.level.opposite, star.flat
    k = star.valence[flat[h]]
    out.add(row, flat[h], 3 / 4 * share)
    for j in range(k.max(initial=0)):
        on = j < k
        out.add(row[on], flat[following(h[on])], share[on] * _ring_weight(j, k[on]))
        h = np.where(on, opposite[previous(h)], h)


def _ring_weight(j: int, k: np.ndarray) -> np.ndarray:
    """Zorin's weight of the j-th of k neighbours, counted from the edge."""
    usual = (1 / 4 + np.cos(2 * np.pi * j / k) + np.cos(4 * np.pi * j / k) / 2) / k
    three = 5 / 12 if j == 0 else -1 / 12
    four = {0: 3 / 8, 2: -1 / 8}.get(j, 0.0)
    return np.where(k == 3, three, np.where(k == 4, four, usual))


def _border_edges(star: _Star, out: _Stencils, row: np.ndarray) -> None:
    """The four-point rule; a border loop gives every vertex one neighbour before and one after."""
    h = star.h[star.rim]
    a, b = star.flat[h], star.flat[following(h)]
    after, before = np.arange(star.n), np.arange(star.n)
    after[a], before[b] = b, a
    row = row[star.rim]
    for vertex, weight in ((a, 9 / 16), (b, 9 / 16), (before[a], WING), (after[b], WING)):
        out.add(row, vertex, weight)


def steps(faces: int) -> int:
    """Subdivisions of a base of so many faces: LEVELS, fewer where that were too many faces, at least one."""
    return max(1, next(s for s in range(LEVELS, -1, -1) if s == 0 or faces * 4**s <= MOST_FACES))


def subdivided(mesh: TriMesh, scheme: Callable[[Level], csr_matrix]) -> TriMesh:
    """The mesh after `steps`. Raises MeshError if it is no oriented manifold."""
    V, level = mesh.V, Level.of(mesh.F, len(mesh.V))
    for _ in range(steps(len(mesh.F))):
        V, level = scheme(level) @ V, level.subdivided()
    return TriMesh(V, level.F)
