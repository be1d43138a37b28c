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

from ..geometry import DIAGONAL, add_outer, orientation_cosine, triangle_normal
from ..jit import compiled
from ..mesh import Level
from ..progress import Progress, no_progress
from .block_cg import conjugate_gradients

NORMAL = 0.1  # weight of the normals: squared height difference along an edge, times the area of the face
SPRING = 0.02  # weight of the squared distance to the point of the map
STIFFER = 10.0  # times more spring round a face that turned over, in each of the ROUNDS
ROUNDS = 6
NEAR = 6  # rings of vertices round such a face that move with it; the others stay
TURNED = 0.3  # cosine between a face and its mapped normal below which it counts as turned over
LEAST = 0.2  # share of a vertex's way from its point of the map below which it goes back all the way


@compiled
def _mapped_faces(F, edge_of, V, middle, P, normal, area):
    """Unit normals (m, 3) and areas (m,), adding up to 1, of what the map makes of the faces: four triangles each, through
    the corners and the points at the middle of the edges. P (6, 3) is work space."""
    total = 0.0
    for f in range(len(F)):
        for c in range(3):
            v, e = F[f, c], edge_of[3 * f + c]
            for k in range(3):
                P[c, k], P[3 + c, k] = V[v, k], middle[e, k]
        x = y = z = sizes = 0.0
        for a, b, c in ((0, 3, 5), (1, 4, 3), (2, 5, 4), (3, 4, 5)):
            nx, ny, nz = triangle_normal(P, a, b, c)
            x, y, z, sizes = x + nx, y + ny, z + nz, sizes + np.sqrt(nx * nx + ny * ny + nz * nz)
        size = max(np.sqrt(x * x + y * y + z * z), 1e-300)
        normal[f, 0], normal[f, 1], normal[f, 2], area[f] = x / size, y / size, z / size, sizes
        total += sizes
    for f in range(len(F)):
        area[f] /= max(total, 1e-300)


@compiled
def _turned(F, X, normal, out):
    """Whether each face of X is turned against its normal of the map, in out (m,) bool; returns whether one is."""
    some = False
    for f in range(len(F)):
        x, y, z = triangle_normal(X, F[f, 0], F[f, 1], F[f, 2])
        out[f] = x * normal[f, 0] + y * normal[f, 1] + z * normal[f, 2] < TURNED * np.sqrt(x * x + y * y + z * z)
        some |= out[f]
    return some


@compiled
def _assemble(F, edges, edge_of, V, direction, middle, middle_direction, area, normal, own, cross, right, share, edge_share):
    """Add the normal equations without springs to blocks own (n, 6) of vertices and cross (e, 6) between the ends of edges,
    minus the gradient at V to right (n, 3), and the area of the vertices to share (n,), of the edges to edge_share (e,)."""
    n, count = len(V), len(edges)
    for f in range(len(F)):
        x, y, z = normal[f, 0], normal[f, 1], normal[f, 2]
        for c in range(3):
            share[F[f, c]] += area[f] / 12
            e = edge_of[3 * f + c]
            edge_share[e] += area[f] / 4
            a, b = edges[e, 0], edges[e, 1]
            w = NORMAL * area[f]
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
        a, b = edges[e, 0], edges[e, 1]
        x, y, z = middle_direction[e, 0], middle_direction[e, 1], middle_direction[e, 2]
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


@compiled
def _stiffen(F, edges, turned, share, fixed, own, spring, ring, vertices, numbers):
    """Stiffen the springs at the corners of turned faces, by STIFFER, and note what is to be solved for again.

    ring (n,) gets how many edges a vertex is away from those, plus 1; 0 from NEAR on. Returns how many vertices, in vertices
    (n,), and edges with a vertex near them, in numbers (e,), there are.
    """
    for v in range(len(ring)):
        ring[v] = 0
    for f in range(len(F)):
        if not turned[f]:
            continue
        for c in range(3):
            v = F[f, c]
            if ring[v] == 0:
                ring[v] = 1
                for d in DIAGONAL:
                    own[v, d] += (STIFFER - 1) * spring[v] * share[v]
                spring[v] *= STIFFER
    for now in range(1, NEAR):
        for e in range(len(edges)):
            a, b = edges[e, 0], edges[e, 1]
            if ring[a] == now and ring[b] == 0:
                ring[b] = now + 1
            elif ring[b] == now and ring[a] == 0:
                ring[a] = now + 1
    near = at = 0
    for v in range(len(ring)):
        if ring[v] > 0 and not fixed[v]:
            vertices[near] = v
            near += 1
    for e in range(len(edges)):
        if ring[edges[e, 0]] > 0 or ring[edges[e, 1]] > 0:
            numbers[at] = e
            at += 1
    return near, at


def fit_to_surface(level: Level, V: np.ndarray, direction: np.ndarray, middle: np.ndarray, middle_direction: np.ndarray,
        progress: Progress = no_progress) -> np.ndarray:
    """Fitted positions (n, 3) float64 of the vertices of a level.

    V (n, 3): their points of the map; middle (e, 3): the points at the middle of the level's edges; direction (n, 3) and
    middle_direction (e, 3): unit normals of the input faces that these lie on. All in the unit frame. Raises whatever
    `progress` raises.
    """
    F = level.F
    normal, area = np.empty((len(F), 3)), np.empty(len(F))
    _mapped_faces(F, level.edge_of, V, middle, np.empty((6, 3)), normal, area)
    fixed = np.zeros(level.n, bool)
    fixed[F.reshape(-1)[level.opposite == np.arange(F.size)]] = True
    n, e = level.n, len(level.edges)
    own, cross, right, share = np.zeros((n, 6)), np.zeros((e, 6)), np.zeros((n, 3)), np.zeros(n)
    _assemble(F, level.edges, level.edge_of, V, direction, middle, middle_direction, area, normal, own, cross, right, share,
              np.zeros(e))
    spring, x = np.full(n, SPRING), np.zeros((n, 3))
    own[:, DIAGONAL] += SPRING * share[:, None] + 1e-15
    turned, ring, near, numbers = np.empty(len(F), bool), np.empty(n, np.int8), np.empty(n, np.int64), np.empty(e, np.int64)
    vertices, edges, least = np.flatnonzero(~fixed), np.arange(e), -1.0
    for done in range(ROUNDS):
        progress(done / ROUNDS, "Fitting the levels")
        least = conjugate_gradients(own, cross, level.edges, right, vertices, edges, x, least)
        X = V + x
        if not _turned(F, X, normal, turned):
            break
        some, edges_there = _stiffen(F, level.edges, turned, share, fixed, own, spring, ring, near, numbers)
        vertices, edges = near[:some], numbers[:edges_there]
    return X


@compiled
def _go_back(F, S, X, N, V, share, moved, looked):
    """Bring V, which is X, back towards S so that no face of F is turned against the normals N that is upright at S; share
    (n,), of ones, gets what is left of each vertex's way. moved (n,), looked (m,), of zeros: when a vertex moved last and when
    a face was looked at; while no corner moves, there is nothing new to see."""
    changed, now = True, 0
    while changed:
        changed = False
        for f in range(len(F)):
            since = looked[f]
            if since > 0 and moved[F[f, 0]] < since and moved[F[f, 1]] < since and moved[F[f, 2]] < since:
                continue
            now += 1
            looked[f] = now
            if orientation_cosine(F, V, N, f) > 0.0 or not orientation_cosine(F, S, N, f) > 0.0:
                continue
            for c in range(3):
                v = F[f, c]
                if share[v] == 0.0:
                    continue
                changed = True
                moved[v] = now
                share[v] = share[v] / 2 if share[v] > LEAST else 0.0
                for k in range(3):
                    V[v, k] = S[v, k] + share[v] * (X[v, k] - S[v, k])
                if share[v] == 0.0:
                    V[v, 0], V[v, 1], V[v, 2] = S[v, 0], S[v, 1], S[v, 2]


def restore_orientation(levels: list[Level], points: np.ndarray, fitted: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Fitted positions (n, 3), some moved back towards the points of the map (n, 3).

    No face of levels 1..L then opposes the sum of its corners' normals (n, 3) that does not at the points of the map.
    """
    F = np.concatenate([level.F for level in levels[1:]])
    V = fitted.copy()
    _go_back(F, points, fitted, normals, V, np.ones(len(V)), np.zeros(len(V), np.int64), np.zeros(len(F), np.int64))
    return V
