"""Conjugate gradients for a symmetric system of three numbers a vertex, coupled along edges.

A matrix is a 3 x 3 block (xx, xy, xz, yy, yz, zz) for each vertex and one for each edge, symmetric too. Some vertices can
be solved for alone, while the others stay: then only these and the edges at them are looked at.
"""
import numpy as np

from ..geometry import invert_blocks
from ..jit import compiled

ITERATIONS = 60
TOLERANCE = 1e-3  # least norm of the preconditioned residual, relative to the first


@compiled
def _own_times(block, vertices, x, out):
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
def _cross_times(cross, edges, numbers, x, out):
    """out += cross x, over the edges with these numbers (k,), both ways."""
    for e in numbers:
        i, j = edges[e, 0], edges[e, 1]
        a, b, c, d, f, g = cross[e, 0], cross[e, 1], cross[e, 2], cross[e, 3], cross[e, 4], cross[e, 5]
        x0, x1, x2, y0, y1, y2 = x[i, 0], x[i, 1], x[i, 2], x[j, 0], x[j, 1], x[j, 2]
        out[i, 0] += a * y0 + b * y1 + c * y2
        out[i, 1] += b * y0 + d * y1 + f * y2
        out[i, 2] += c * y0 + f * y1 + g * y2
        out[j, 0] += a * x0 + b * x1 + c * x2
        out[j, 1] += b * x0 + d * x1 + f * x2
        out[j, 2] += c * x0 + f * x1 + g * x2


@compiled(allocates=True)
def conjugate_gradients(own, cross, edges, right, vertices, numbers, x, least):
    """Bring the displacements x (n, 3) of the vertices (k,) to a solution of their normal equations, while the others stay, by
    conjugate gradients with the blocks of the vertices.

    numbers: of the edges with such a vertex. least: preconditioned residual (r' own^-1 r) that may be left, a share
    TOLERANCE^2 of that without displacements where it is negative. Returns it.
    """
    n = len(own)
    inverse, p, q, r, s = np.empty((n, 6)), np.zeros((n, 3)), np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    invert_blocks(own, vertices, inverse)
    if least < 0.0:
        least = TOLERANCE * TOLERANCE * _own_times(inverse, vertices, right, s)
    _own_times(own, vertices, x, q)
    _cross_times(cross, edges, numbers, x, q)
    for v in vertices:
        for c in range(3):
            r[v, c] = right[v, c] - q[v, c]
    rs = _own_times(inverse, vertices, r, s)
    for v in vertices:
        p[v, 0], p[v, 1], p[v, 2] = s[v, 0], s[v, 1], s[v, 2]
    for _ in range(ITERATIONS):
        if not rs > least:
            break
        _own_times(own, vertices, p, q)
        _cross_times(cross, edges, numbers, p, q)
        total = 0.0
        for v in vertices:
            total += p[v, 0] * q[v, 0] + p[v, 1] * q[v, 1] + p[v, 2] * q[v, 2]
        step = rs / total
        for v in vertices:
            for c in range(3):
                x[v, c] += step * p[v, c]
                r[v, c] -= step * q[v, c]
        before, rs = rs, _own_times(inverse, vertices, r, s)
        for v in vertices:
            for c in range(3):
                p[v, c] = s[v, c] + rs / before * p[v, c]
    return least
