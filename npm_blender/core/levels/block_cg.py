"""Conjugate gradients for a symmetric system A x = b of three numbers a vertex, coupled along edges.

The method is that of Hestenes and Stiefel (1952), preconditioned by block Jacobi: with the inverses of the 3 x 3 blocks of the
vertices on the diagonal of A. Some vertices can be solved for alone, while the others stay: then only these and the edges at
them are looked at.
"""
from typing import NamedTuple

import numpy as np

from ..geometry import invert_blocks
from ..jit import compiled

ITERATIONS = 60
TOLERANCE = 1e-3  # least norm of the preconditioned residual, relative to the first


class BlockMatrix(NamedTuple):
    """A symmetric matrix of 3 x 3 blocks, which are symmetric too (see `geometry.symmetric3`): diagonal (n, 6) float64, one
    for each vertex; off_diagonal (e, 6), one for each of the edges (e, 2) int32, in the rows and columns of its two ends."""

    diagonal: np.ndarray
    off_diagonal: np.ndarray
    edges: np.ndarray


@compiled
def _diagonal_times(block, vertices, x, out):
    """out = block x at the vertices (k,); returns their product x' block x."""
    total = 0.0
    for v in vertices:
        x0, x1, x2 = x[v, 0], x[v, 1], x[v, 2]
        y0 = block[v, 0] * x0 + block[v, 1] * x1 + block[v, 2] * x2
        y1 = block[v, 1] * x0 + block[v, 3] * x1 + block[v, 4] * x2
        y2 = block[v, 2] * x0 + block[v, 4] * x1 + block[v, 5] * x2
        out[v, 0], out[v, 1], out[v, 2] = y0, y1, y2
        total += x0 * y0 + x1 * y1 + x2 * y2
    return total


@compiled
def _add_off_diagonal_times(matrix, numbers, x, out):
    """out += off_diagonal x, over the edges with these numbers (k,), both ways."""
    edges, block = matrix.edges, matrix.off_diagonal
    for e in numbers:
        i, j = edges[e, 0], edges[e, 1]
        a, b, c, d, f, g = block[e, 0], block[e, 1], block[e, 2], block[e, 3], block[e, 4], block[e, 5]
        x0, x1, x2, y0, y1, y2 = x[i, 0], x[i, 1], x[i, 2], x[j, 0], x[j, 1], x[j, 2]
        out[i, 0] += a * y0 + b * y1 + c * y2
        out[i, 1] += b * y0 + d * y1 + f * y2
        out[i, 2] += c * y0 + f * y1 + g * y2
        out[j, 0] += a * x0 + b * x1 + c * x2
        out[j, 1] += b * x0 + d * x1 + f * x2
        out[j, 2] += c * x0 + f * x1 + g * x2


@compiled(allocates=True)
def conjugate_gradients(matrix, rhs, vertices, numbers, x, least):
    """Bring the rows of x (n, 3) at the vertices (k,) int64 towards the solution of matrix x = rhs, while the others stay.

    With A = matrix, D its diagonal and b = rhs, at first r = b - A x, s = D^-1 r, p = s; a step, with t = r's / p'A p, is
    x += t p, r -= t A p, s = D^-1 r, p = s + (r's / the one before) p. It ends where r's <= least, or after ITERATIONS steps.

    matrix: a BlockMatrix, positive definite; rhs (n, 3) float64; numbers (l,) int64: of the edges with such a vertex; least: a
    number, or negative for TOLERANCE^2 times the r's of x = 0. Returns least.
    """
    diagonal, n = matrix.diagonal, len(matrix.diagonal)
    inverse, p, q, r, s = np.empty((n, 6)), np.zeros((n, 3)), np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    invert_blocks(diagonal, vertices, inverse)
    if least < 0.0:
        least = TOLERANCE * TOLERANCE * _diagonal_times(inverse, vertices, rhs, s)
    _diagonal_times(diagonal, vertices, x, q)
    _add_off_diagonal_times(matrix, numbers, x, q)
    for v in vertices:
        for c in range(3):
            r[v, c] = rhs[v, c] - q[v, c]
    rs = _diagonal_times(inverse, vertices, r, s)
    for v in vertices:
        p[v, 0], p[v, 1], p[v, 2] = s[v, 0], s[v, 1], s[v, 2]
    for _ in range(ITERATIONS):
        if not rs > least:
            break
        _diagonal_times(diagonal, vertices, p, q)
        _add_off_diagonal_times(matrix, numbers, p, q)
        total = 0.0
        for v in vertices:
            total += p[v, 0] * q[v, 0] + p[v, 1] * q[v, 1] + p[v, 2] * q[v, 2]
        step = rs / total
        for v in vertices:
            for c in range(3):
                x[v, c] += step * p[v, c]
                r[v, c] -= step * q[v, c]
        before, rs = rs, _diagonal_times(inverse, vertices, r, s)
        for v in vertices:
            for c in range(3):
                p[v, c] = s[v, c] + rs / before * p[v, c]
    return least
