"""Quadric error metrics (Garland and Heckbert 1997): area-weighted face planes, border planes, and where an edge goes.

A quadric is ten numbers (xx, xy, xz, yy, yz, zz, bx, by, bz, c) with E(x) = x'Ax + 2 b'x + c.
"""
import numpy as np

from ..geometry import add_outer, next_halfedge
from ..jit import compiled
from ..parallel import each

BORDER_WEIGHT = 1.0  # of a border edge's perpendicular plane, times its squared length (a face counts with its area)
PULL = 1e-6  # regularisation of the optimal position, relative to the trace of A: flat directions go to the midpoint
SLICE = 32_000  # edges that one thread takes at a time
REACH = 2.0  # the optimal position may lie this many edge lengths away from the midpoint


@compiled
def _add_plane(q, a, b, c, d, w):
    """Add w times the squared distance to the plane a x + b y + c z + d = 0 (unit normal) to quadric q."""
    add_outer(q, a, b, c, w)
    q[6] += w * a * d
    q[7] += w * b * d
    q[8] += w * c * d
    q[9] += w * d * d


def vertex_quadrics(X: np.ndarray, corner: np.ndarray, opposite: np.ndarray) -> np.ndarray:
    """Quadrics (n, 10) of vertices X (n, 3) of the mesh with corner vertices `corner` (3 m,) and its opposites."""
    Q = np.zeros((len(X), 10))
    _add_planes(X, corner, opposite, Q)
    return Q


@compiled
def _add_planes(X, corner, opposite, Q):
    """Add the planes of all faces and border edges to the quadrics Q (n, 10) of their vertices."""
    for f in range(len(corner) // 3):
        i, j, k = corner[3 * f], corner[3 * f + 1], corner[3 * f + 2]
        ux, uy, uz = X[j, 0] - X[i, 0], X[j, 1] - X[i, 1], X[j, 2] - X[i, 2]
        vx, vy, vz = X[k, 0] - X[i, 0], X[k, 1] - X[i, 1], X[k, 2] - X[i, 2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = np.sqrt(nx * nx + ny * ny + nz * nz)
        if length < 1e-30:
            continue
        nx, ny, nz = nx / length, ny / length, nz / length
        d = -(nx * X[i, 0] + ny * X[i, 1] + nz * X[i, 2])
        for s in range(3):
            _add_plane(Q[corner[3 * f + s]], nx, ny, nz, d, length / 2)
        for s in range(3):
            if opposite[3 * f + s] != 3 * f + s:
                continue
            a, b = corner[3 * f + s], corner[3 * f + (s + 1) % 3]
            ex, ey, ez = X[b, 0] - X[a, 0], X[b, 1] - X[a, 1], X[b, 2] - X[a, 2]
            e2 = ex * ex + ey * ey + ez * ez
            if e2 < 1e-30:
                continue
            e = np.sqrt(e2)
            px, py, pz = (ny * ez - nz * ey) / e, (nz * ex - nx * ez) / e, (nx * ey - ny * ex) / e
            d2 = -(px * X[a, 0] + py * X[a, 1] + pz * X[a, 2])
            _add_plane(Q[a], px, py, pz, d2, BORDER_WEIGHT * e2)
            _add_plane(Q[b], px, py, pz, d2, BORDER_WEIGHT * e2)


@compiled
def _value(q, x, y, z):
    """E(x, y, z) of a quadric q, a tuple of its ten numbers."""
    q0, q1, q2, q3, q4, q5, q6, q7, q8, q9 = q
    return (q0 * x * x + q3 * y * y + q5 * z * z + 2 * (q1 * x * y + q2 * x * z + q4 * y * z)
            + 2 * (q6 * x + q7 * y + q8 * z) + q9)


@compiled
def best_point(Q, X, i, j):
    """Cost and position (cost, x, y, z) of collapsing the edge between vertices i and j (Garland and Heckbert 1997).

    Q (n, 10) and X (n, 3) float64: quadrics and positions of the vertices. The cost is E(x) = x'Ax + 2 b'x + c of the sum of
    both quadrics at the point where it is least, A x = -b, with A regularised so that flat directions go to the midpoint
    (ours); where that point lies out of reach, at the best of the two ends and the midpoint.

    >>> import numpy as np
    >>> from npm_blender.core.decimation import best_point
    >>> Q = np.zeros((2, 10))
    >>> Q[0, [0, 3]], Q[1, [5, 8, 9]] = 1, (1, -0.5, 0.25)  # x^2 + y^2, and (z - 1/2)^2: the edge meets at (0, 0, 1/2)
    >>> X = np.array([[0.0, 0.0, 0.0], [0.2, 0.0, 0.6]])
    >>> [abs(round(float(v), 4)) for v in best_point(Q, X, 0, 1)]
    [0.0, 0.0, 0.0, 0.5]
    """
    q0, q1, q2, q3, q4 = Q[i, 0] + Q[j, 0], Q[i, 1] + Q[j, 1], Q[i, 2] + Q[j, 2], Q[i, 3] + Q[j, 3], Q[i, 4] + Q[j, 4]
    q5, q6, q7, q8, q9 = Q[i, 5] + Q[j, 5], Q[i, 6] + Q[j, 6], Q[i, 7] + Q[j, 7], Q[i, 8] + Q[j, 8], Q[i, 9] + Q[j, 9]
    q = q0, q1, q2, q3, q4, q5, q6, q7, q8, q9
    mx, my, mz = (X[i, 0] + X[j, 0]) / 2, (X[i, 1] + X[j, 1]) / 2, (X[i, 2] + X[j, 2]) / 2
    ex, ey, ez = X[j, 0] - X[i, 0], X[j, 1] - X[i, 1], X[j, 2] - X[i, 2]
    e2 = ex * ex + ey * ey + ez * ez
    gx = q0 * mx + q1 * my + q2 * mz + q6
    gy = q1 * mx + q3 * my + q4 * mz + q7
    gz = q2 * mx + q4 * my + q5 * mz + q8
    pull = PULL * (q0 + q3 + q5) + 1e-300
    a, b, c = q0 + pull, q3 + pull, q5 + pull
    c00, c01, c02 = b * c - q4 * q4, q2 * q4 - q1 * c, q1 * q4 - q2 * b
    det = a * c00 + q1 * c01 + q2 * c02
    if det > 0.0:
        c11, c12, c22 = a * c - q2 * q2, q1 * q2 - a * q4, a * b - q1 * q1
        dx = -(c00 * gx + c01 * gy + c02 * gz) / det
        dy = -(c01 * gx + c11 * gy + c12 * gz) / det
        dz = -(c02 * gx + c12 * gy + c22 * gz) / det
        if dx * dx + dy * dy + dz * dz <= REACH * REACH * e2:
            x, y, z = mx + dx, my + dy, mz + dz
            return max(_value(q, x, y, z), 0.0), x, y, z
    cost = max(_value(q, mx, my, mz), 0.0)
    x, y, z = mx, my, mz
    for v in (i, j):
        at = max(_value(q, X[v, 0], X[v, 1], X[v, 2]), 0.0)
        if at < cost:
            cost, x, y, z = at, X[v, 0], X[v, 1], X[v, 2]
    return cost, x, y, z


@compiled
def _costs(Q, X, corner, start, first, last, cost):
    """Fill cost[first:last]; see `edge_costs`."""
    for e in range(first, last):
        h = start[e]
        cost[e], _, _, _ = best_point(Q, X, corner[h], corner[next_halfedge(h)])


def edge_costs(Q: np.ndarray, X: np.ndarray, corner: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Cost (e,) float64 of every edge, that of its `best_point` (Garland and Heckbert 1997).

    Q (n, 10), X (n, 3): quadrics and positions of the vertices; corner (3 m,) int32: the vertex that each half-edge leaves;
    start (e,) int32: one half-edge of each edge.

    >>> import numpy as np
    >>> from npm_blender.core.decimation import edge_costs, half_edges_with_quadrics
    >>> from npm_blender.core.mesh import TriMesh
    >>> V = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> m, Q = half_edges_with_quadrics(TriMesh.from_arrays(V, np.array([[0, 1, 2], [0, 2, 3]])))
    >>> cost = edge_costs(Q, m.X, m.corner, m.start)  # of a square: its sides would cost its outline, the diagonal even more
    >>> [[int(m.corner[h]), int(m.corner[h - 2 if h % 3 == 2 else h + 1])] for h in m.start[np.argsort(cost, kind="stable")]][-1]
    [2, 0]
    """
    cost = np.empty(len(start))
    each(lambda e: _costs(Q, X, corner, start, e, min(e + SLICE, len(start)), cost), range(0, len(start), SLICE))
    return cost
