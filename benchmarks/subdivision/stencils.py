"""Linear subdivision as sparse matrices: midpoints, blended with Loop's scheme (Loop 1987)."""

import numpy as np
from scipy.sparse import csr_matrix

from npm_blender.core.mesh import Level


def refinement(level: Level, smooth: float) -> csr_matrix:
    """Matrix ((n + e), n) float64 from the vertices of a level to those of the next.

    smooth 0: vertices stay and new ones are midpoints; 1: Loop's masks, with cubic B-splines along borders; between:
    the blend of both.
    """
    n, e = level.n, len(level.edges)
    left, right = level.edge_halfedge.T.astype(np.int64)
    inner = left != right
    a, b = level.edges.T.astype(np.int64)
    flat = level.F.reshape(-1).astype(np.int64)
    apex = [flat[h - h % 3 + (h + 2) % 3] for h in (left, right)]
    new = n + np.arange(e)
    share = np.where(inner, 0.5 - smooth / 8, 0.5)
    rows = [new, new, new[inner], new[inner]]
    columns = [a, b, apex[0][inner], apex[1][inner]]
    values = [share, share, *[np.full(int(inner.sum()), smooth / 8)] * 2]
    border = np.zeros(n, bool)
    border[level.edges[~inner].reshape(-1)] = True
    used = inner[:, None] | np.ones(2, bool)
    used = used & ~(border[level.edges] & inner[:, None])  # a border vertex sees its border neighbours only
    valence = np.bincount(level.edges.reshape(-1), used.reshape(-1), n)
    k = np.maximum(valence, 1)
    beta = (0.625 - (0.375 + 0.25 * np.cos(2 * np.pi / k)) ** 2) / k
    beta = smooth * np.where(border, 1 / 8, beta)
    for own, other, take in ((a, b, used[:, 0]), (b, a, used[:, 1])):
        rows.append(own[take])
        columns.append(other[take])
        values.append(beta[own[take]])
    rows.append(np.arange(n))
    columns.append(np.arange(n))
    values.append(1 - valence * beta)
    shape = (n + e, n)
    return csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape)


def edge_points(level: Level) -> csr_matrix:
    """Matrix (e, n) from vertices to the midpoints of edges, at which face integrals of quadratics are exact."""
    e = len(level.edges)
    rows = np.repeat(np.arange(e), 2)
    return csr_matrix((np.full(2 * e, 0.5), (rows, level.edges.reshape(-1))), (e, level.n))
