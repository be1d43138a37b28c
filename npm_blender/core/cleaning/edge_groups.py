"""Which half-edges share an edge, for any triangles at all: the checks and repairs of `clean` stand on this.

Nothing is assumed to be a manifold. Half-edges and corners are numbered as in `mesh.topology`: h = 3 f + k runs from corner k
of face f; the corner at its start is h, the corner at its end is next(h).
"""
from dataclasses import dataclass

import numpy as np

from ..geometry import end_of, find_root, next_halfedge, unite
from ..jit import compiled


@dataclass(frozen=True)
class EdgeGroups:
    """The half-edges of faces F (m, 3) over n vertices, grouped by undirected edge.

    halfedges: (3 m,) int32, sorted by (smaller vertex, larger vertex), then by number; starts: (e + 1,) int64, group i
    is halfedges[starts[i]:starts[i + 1]]. Faces that name a vertex twice have half-edges from a vertex to itself.
    """

    F: np.ndarray
    n: int
    halfedges: np.ndarray
    starts: np.ndarray

    @staticmethod
    def of(F: np.ndarray, n: int) -> "EdgeGroups":
        """The groups of faces F (m, 3) int32 over n vertices."""
        return EdgeGroups(F, n, *_groups(np.ascontiguousarray(F, np.int32).reshape(-1), n))

    def replaced(self, F: np.ndarray) -> "EdgeGroups":
        """The groups of other faces over the same vertices; these ones where F is the very array that they are of."""
        return self if F is self.F else EdgeGroups.of(F, self.n)

    @property
    def sizes(self) -> np.ndarray:
        """Number of half-edges of each edge, (e,) int64: 1 on the border, 2 inside, more where non-manifold."""
        return np.diff(self.starts)

    @property
    def border(self) -> np.ndarray:
        """The half-edges of edges of one face, (b,) int32, by edge."""
        return self.halfedges[self.starts[:-1][self.sizes == 1]]

    def disagree(self) -> np.ndarray:
        """(e,) bool: edges of two faces that run along it the same way."""
        two, flat = self.sizes == 2, self.F.reshape(-1)
        h = self.starts[:-1][two]
        out = np.zeros(len(two), bool)
        out[two] = flat[self.halfedges[h]] == flat[self.halfedges[h + 1]]
        return out


@compiled(allocates=True)
def _groups(flat, n):
    size = len(flat)
    order, sorted_by_high = np.zeros(size, np.int32), np.zeros(size, np.int32)
    for step in range(2):  # counting sort, by the larger vertex and then by the smaller one
        at = np.zeros(n + 1, np.int64)
        for h in range(size):
            a, b = flat[h], end_of(flat, h)
            at[(max(a, b) if step == 0 else min(a, b)) + 1] += 1
        for v in range(n):
            at[v + 1] += at[v]
        for i in range(size):
            h = i if step == 0 else sorted_by_high[i]
            a, b = flat[h], end_of(flat, h)
            v = max(a, b) if step == 0 else min(a, b)
            if step == 0:
                sorted_by_high[at[v]] = h
            else:
                order[at[v]] = h
            at[v] += 1
    starts = np.zeros(size + 1, np.int64)
    count = 0
    for i in range(size):
        a, b = flat[order[i]], end_of(flat, order[i])
        p, q = (flat[order[i - 1]], end_of(flat, order[i - 1])) if i else (a, b)
        if i == 0 or min(a, b) != min(p, q) or max(a, b) != max(p, q):
            starts[count] = i
            count += 1
    starts[count] = size
    return order, starts[:count + 1].copy()


@compiled(allocates=True)
def face_parts(m, halfedges, starts):
    """Smallest face joined to each face across edges of any kind, (m,) int32."""
    parent = np.arange(m).astype(np.int32)
    for g in range(len(starts) - 1):
        for i in range(starts[g] + 1, starts[g + 1]):
            unite(parent, halfedges[i - 1] // 3, halfedges[i] // 3)
    for f in range(m):
        parent[f] = find_root(parent, f)
    return parent


@compiled(allocates=True)
def corner_parts(flat, halfedges, starts):
    """Smallest corner joined to each corner round its vertex across edges of any kind, (3 m,) int32."""
    parent = np.arange(len(flat)).astype(np.int32)
    for g in range(len(starts) - 1):
        for i in range(starts[g] + 1, starts[g + 1]):
            join_corners(parent, flat, halfedges[i - 1], halfedges[i])
    for h in range(len(flat)):
        parent[h] = find_root(parent, h)
    return parent


@compiled
def join_corners(parent, flat, h, g):
    """Join the corners of half-edges h and g of one edge at both of its ends."""
    if flat[h] == flat[g]:
        unite(parent, h, g)
        unite(parent, next_halfedge(h), next_halfedge(g))
    else:
        unite(parent, h, next_halfedge(g))
        unite(parent, next_halfedge(h), g)


@compiled(allocates=True)
def vertex_parts(n, a, b):
    """Smallest vertex joined to each of n vertices by the pairs a-b, (n,) int32."""
    parent = np.arange(n).astype(np.int32)
    for i in range(len(a)):
        unite(parent, a[i], b[i])
    for v in range(n):
        parent[v] = find_root(parent, v)
    return parent
