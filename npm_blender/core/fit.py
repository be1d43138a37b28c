"""Vertices of the finest level, fitted to the input surface instead of sampled from it.

A mesh whose vertices lie on a curved surface lies on one side of it, and cuts off every crease that runs between its
vertices. So the sampled points, and the points of the map at the middle of every edge, each ask for the distance of the
mesh to the plane of the input face that they lie on; the mapped normal of every face asks its edges to be perpendicular
to it; and a weak spring holds each vertex near its point of the map. The sum of squares is minimised by conjugate
gradients. Vertices may slide along the surface, which is how they find creases and corners, as in a quadric error metric
(Garland and Heckbert 1997). Vertices of the border stay. Where this turns over a face, of any level, that the points of
the map leave upright, its vertices go back towards those points (see `upright`).
"""
import numpy as np

from .jit import compiled
from .normals import normal as triangle_normal
from .progress import Progress, no_progress
from .quadric import add_outer
from .rings import cosine
from .subdivide import Level

NORMAL = 0.1  # weight of the normals: squared height difference along an edge, times the area of the face
SPRING = 0.02  # weight of the squared distance to the point of the map
STIFFER = 10.0  # times more spring round a face that turned over, in each of the ROUNDS
ROUNDS = 6
TURNED = 0.3  # cosine between a face and its mapped normal below which it counts as turned over
LEAST = 0.2  # share of a vertex's way from its point of the map below which it goes back all the way
ITERATIONS = 60
DIAGONAL = [0, 3, 5]  # of a symmetric 3 x 3 block
TOLERANCE = 1e-4  # least norm of the preconditioned residual, relative to the first


@compiled(allocates=True)
def _mapped_faces(F, edge_of, V, middle):
    """Unit normals (m, 3) and areas (m,), adding up to 1, of what the map makes of the faces: four triangles each, through
    the corners and the points at the middle of the edges."""
    normal, area, total = np.empty((len(F), 3)), np.empty(len(F)), 0.0
    P = np.empty((6, 3))
    for f in range(len(F)):
        for c in range(3):
            P[c], P[3 + c] = V[F[f, c]], middle[edge_of[3 * f + c]]
        x = y = z = sizes = 0.0
        for a, b, c in ((0, 3, 5), (1, 4, 3), (2, 5, 4), (3, 4, 5)):
            nx, ny, nz = triangle_normal(P, a, b, c)
            x, y, z, sizes = x + nx, y + ny, z + nz, sizes + np.sqrt(nx * nx + ny * ny + nz * nz)
        size = max(np.sqrt(x * x + y * y + z * z), 1e-300)
        normal[f, 0], normal[f, 1], normal[f, 2], area[f] = x / size, y / size, z / size, sizes
        total += sizes
    return normal, area / max(total, 1e-300)


@compiled(allocates=True)
def _turned(F, X, normal):
    """Whether each face of X is turned against its normal of the map, (m,) bool."""
    out = np.zeros(len(F), np.bool_)
    for f in range(len(F)):
        x, y, z = triangle_normal(X, F[f, 0], F[f, 1], F[f, 2])
        out[f] = x * normal[f, 0] + y * normal[f, 1] + z * normal[f, 2] < TURNED * np.sqrt(x * x + y * y + z * z)
    return out


@compiled(allocates=True)
def _assemble(F, edges, edge_of, V, direction, middle, middle_direction, area, normal, fixed, normal_weight):
    """The normal equations without springs: blocks (n, 6) of vertices, (e, 6) between the ends of edges, minus the gradient
    at V, and the area (n,) of the vertices.

    A fixed vertex gets no right side, so that conjugate gradients leave it where it is.
    """
    n, count = len(V), len(edges)
    own, cross = np.zeros((n, 6)), np.zeros((count, 6))
    right = np.zeros((n, 3))
    share, edge_share = np.zeros(n), np.zeros(count)
    for f in range(len(F)):
        x, y, z = normal[f]
        for c in range(3):
            share[F[f, c]] += area[f] / 12
            e = edge_of[3 * f + c]
            edge_share[e] += area[f] / 4
            a, b = edges[e]
            w = normal_weight * area[f]
            add_outer(own[a], x, y, z, w)
            add_outer(own[b], x, y, z, w)
            add_outer(cross[e], x, y, z, -w)
            h = w * (x * (V[b, 0] - V[a, 0]) + y * (V[b, 1] - V[a, 1]) + z * (V[b, 2] - V[a, 2]))
            right[a, 0] += h * x
            right[a, 1] += h * y
            right[a, 2] += h * z
            right[b, 0] -= h * x
            right[b, 1] -= h * y
            right[b, 2] -= h * z
    for v in range(n):
        add_outer(own[v], direction[v, 0], direction[v, 1], direction[v, 2], share[v])
    for e in range(count):
        a, b = edges[e]
        x, y, z = middle_direction[e]
        w = edge_share[e] / 4
        add_outer(own[a], x, y, z, w)
        add_outer(own[b], x, y, z, w)
        add_outer(cross[e], x, y, z, w)
        gap = 0.0
        for c in range(3):
            gap += middle_direction[e, c] * (middle[e, c] - (V[a, c] + V[b, c]) / 2)
        for c in range(3):
            right[a, c] += 2 * w * gap * middle_direction[e, c]
            right[b, c] += 2 * w * gap * middle_direction[e, c]
    for v in range(n):
        if fixed[v]:
            right[v] = 0.0
    return own, cross, right, share


@compiled
def _times(block, at, x, out, to):
    """Add block[at] x[at'] to out[to], for a symmetric 3 x 3 block and the row x."""
    out[to, 0] += block[at, 0] * x[0] + block[at, 1] * x[1] + block[at, 2] * x[2]
    out[to, 1] += block[at, 1] * x[0] + block[at, 3] * x[1] + block[at, 4] * x[2]
    out[to, 2] += block[at, 2] * x[0] + block[at, 4] * x[1] + block[at, 5] * x[2]


@compiled
def _solve_own(own, r, out):
    """out = own^-1 r, vertex by vertex."""
    for v in range(len(own)):
        a, b, c, d, e, f = own[v]
        c00, c01, c02 = d * f - e * e, c * e - b * f, b * e - c * d
        c11, c12, c22 = a * f - c * c, b * c - a * e, a * d - b * b
        det = a * c00 + b * c01 + c * c02
        out[v, 0] = (c00 * r[v, 0] + c01 * r[v, 1] + c02 * r[v, 2]) / det
        out[v, 1] = (c01 * r[v, 0] + c11 * r[v, 1] + c12 * r[v, 2]) / det
        out[v, 2] = (c02 * r[v, 0] + c12 * r[v, 1] + c22 * r[v, 2]) / det


@compiled
def _dot(a, b):
    total = 0.0
    for v in range(len(a)):
        total += a[v, 0] * b[v, 0] + a[v, 1] * b[v, 1] + a[v, 2] * b[v, 2]
    return total


@compiled
def _product(own, cross, edges, fixed, p, q):
    """q = the normal equations' matrix times p; zero at fixed vertices."""
    q[:] = 0.0
    for v in range(len(own)):
        _times(own, v, p[v], q, v)
    for e in range(len(edges)):
        a, b = edges[e]
        _times(cross, e, p[b], q, a)
        _times(cross, e, p[a], q, b)
    for v in range(len(own)):
        if fixed[v]:
            q[v] = 0.0


@compiled(allocates=True)
def _descend(own, cross, edges, right, fixed, x, iterations, tolerance):
    """Bring the displacements x (n, 3) to a solution of the normal equations, by conjugate gradients with the blocks of the
    vertices. tolerance: relative to the residual without displacements."""
    n = len(own)
    q, s = np.empty((n, 3)), np.empty((n, 3))
    _solve_own(own, right, s)
    first = _dot(right, s)
    _product(own, cross, edges, fixed, x, q)
    r = right - q
    _solve_own(own, r, s)
    p = s.copy()
    rs = _dot(r, s)
    for _ in range(iterations):
        if not rs > tolerance * tolerance * first:
            break
        _product(own, cross, edges, fixed, p, q)
        step = rs / _dot(p, q)
        for v in range(n):
            for c in range(3):
                x[v, c] += step * p[v, c]
                r[v, c] -= step * q[v, c]
        _solve_own(own, r, s)
        before, rs = rs, _dot(r, s)
        for v in range(n):
            for c in range(3):
                p[v, c] = s[v, c] + rs / before * p[v, c]


def fit(level: Level, V: np.ndarray, direction: np.ndarray, middle: np.ndarray, middle_direction: np.ndarray,
        progress: Progress = no_progress) -> np.ndarray:
    """Fitted positions (n, 3) float64 of the vertices of a level.

    V (n, 3): their points of the map; middle (e, 3): the points at the middle of the level's edges; direction (n, 3) and
    middle_direction (e, 3): unit normals of the input faces that these lie on. All in the unit frame. Raises whatever
    `progress` raises.
    """
    F = level.F
    normal, area = _mapped_faces(F, level.edge_of, V, middle)
    fixed = np.zeros(level.n, bool)
    fixed[F.reshape(-1)[level.opposite == np.arange(F.size)]] = True
    own, cross, right, share = _assemble(F, level.edges, level.edge_of, V, direction, middle, middle_direction, area, normal,
                                         fixed, NORMAL)
    spring, x = np.full((level.n, 1), SPRING), np.zeros((level.n, 3))
    own[:, DIAGONAL] += spring * share[:, None] + 1e-15
    for done in range(ROUNDS):
        progress(done / ROUNDS, "Fitting the levels")
        _descend(own, cross, level.edges, right, fixed, x, ITERATIONS, TOLERANCE)
        X = V + x
        turned = _turned(F, X, normal)
        if not turned.any():
            break
        at = np.unique(F[turned])
        own[np.ix_(at, DIAGONAL)] += (STIFFER - 1) * spring[at] * share[at, None]
        spring[at] *= STIFFER
    return X


@compiled(allocates=True)
def _go_back(F, S, X, N):
    """Points between S and X so that no face of F is turned against the normals N that is upright at S."""
    V, share = X.copy(), np.ones(len(X))
    changed = True
    while changed:
        changed = False
        for f in range(len(F)):
            if cosine(F, V, N, f) > 0.0 or not cosine(F, S, N, f) > 0.0:
                continue
            for c in range(3):
                v = F[f, c]
                if share[v] == 0.0:
                    continue
                changed = True
                share[v] = share[v] / 2 if share[v] > LEAST else 0.0
                for k in range(3):
                    V[v, k] = S[v, k] + share[v] * (X[v, k] - S[v, k])
                if share[v] == 0.0:
                    V[v] = S[v]
    return V


def upright(levels: list[Level], points: np.ndarray, fitted: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Fitted positions (n, 3), some moved back towards the points of the map (n, 3).

    No face of levels 1..L then opposes the sum of its corners' normals (n, 3) that does not at the points of the map.
    """
    F = np.concatenate([level.F for level in levels[1:]])
    return _go_back(F, points, fitted, normals)
