"""Vertices of the finest level, fitted to the input surface instead of sampled from it.

A mesh whose vertices lie on a curved surface lies on one side of it, and cuts off every crease that runs between its
vertices. So the sampled points, and the points of the map at the middle of every edge, each ask for the distance of the
mesh to the plane of the input face that they lie on; the mapped normal of every face asks its edges to be perpendicular
to it; and a weak spring holds each vertex near its point of the map. The positions x of the vertices minimise

    E(x) =       sum_v a_v (n_v . (x_v - p_v))^2               vertices v on the planes of their points p_v, with normals n_v
         +       sum_e a_e (n_e . (m_e - p_e))^2               middles m_e = (x_i + x_j) / 2 of edges e = ij on those of theirs
         + w_n   sum_f a_f sum_(e of f) (n_f . (x_j - x_i))^2  faces f perpendicular to their mapped normals n_f
         + w_s   sum_v a_v |x_v - p_v|^2                       springs

with w_n = NORMAL and w_s = SPRING. a_f is the area of what the map makes of face f, four triangles through the points of its
corners and edges; the areas add up to 1. a_v and a_e are thirds of the areas of those small triangles that have the point as
a corner, and add up to 1 as well. E is solved for by conjugate gradients (see `block_cg`). Vertices may slide along the surface,
which is how they find creases and corners, as in a quadric error metric (Garland and Heckbert 1997). Vertices of the border
stay. Where this flips a face (FLIPPED_FIT), the springs of its corners get stiffer; where it flips a face of any level (OPPOSED)
that the points of the map do not, its vertices go back towards those points. The combination of the terms is ours.
"""
from typing import NamedTuple

import numpy as np

from ..geometry import DIAGONAL, FLIPPED_FIT, OPPOSED, add_outer, is_flipped, is_flipped_from, triangle_normal
from ..jit import compiled
from ..mesh import Level
from ..progress import Progress, no_progress
from .block_cg import BlockMatrix, conjugate_gradients

NORMAL = 0.1  # w_n, weight of the normals: squared height difference along an edge, times the area of the face
SPRING = 0.02  # w_s, weight of the springs: squared distance of a vertex to its point of the map, times the area of the vertex
STIFFER = 10.0  # times more spring at the corners of a face that is flipped, in each of the ROUNDS
ROUNDS = 6
NEAR = 6  # rings of vertices round such a face that are solved for again; the others stay
LEAST = 0.2  # share of a vertex's way from its point of the map below which it goes back all the way


class Targets(NamedTuple):
    """What the fit aims at: points of the map and unit normals of the input faces that they lie on; points, normals (n, 3):
    of the vertices, middles, middle_normals (e, 3): of the middles of the edges. All float64."""

    points: np.ndarray
    normals: np.ndarray
    middles: np.ndarray
    middle_normals: np.ndarray


class MappedFaces(NamedTuple):
    """What the map makes of each face: unit normal n_f (m, 3), zero where it has none, and area a_f (m,), adding up to 1."""

    normal: np.ndarray
    area: np.ndarray


class NormalEquations(NamedTuple):
    """matrix d = rhs for the displacements d (n, 3) from the points of the map; area (n,): a_v of the vertices."""

    matrix: BlockMatrix
    rhs: np.ndarray
    area: np.ndarray


@compiled
def _map_faces(F, edge_of, targets, P, mapped):
    """Set the normals and areas of a MappedFaces: of four triangles each, through the corners and the points at the middle of the
    edges. P (6, 3) is work space."""
    normal, area, total = mapped.normal, mapped.area, 0.0
    for f in range(len(F)):
        for c in range(3):
            v, e = F[f, c], edge_of[3 * f + c]
            for k in range(3):
                P[c, k], P[3 + c, k] = targets.points[v, k], targets.middles[e, k]
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
def _find_flipped(F, X, normal, out):
    """Whether each face of X is flipped against its mapped normal, in out (m,) bool; returns whether one is."""
    some = False
    for f in range(len(F)):
        out[f] = is_flipped_from(F, X, normal, f, FLIPPED_FIT)
        some |= out[f]
    return some


@compiled
def _add_normals(F, edge_of, V, mapped, equations, edge_area):
    """Add the term of the normals, w_n, and the areas a_v to the equations, and a_e to edge_area (e,)."""
    (diagonal, off_diagonal, edges), rhs = equations.matrix, equations.rhs
    normal, area = mapped.normal, mapped.area
    for f in range(len(F)):
        x, y, z = normal[f, 0], normal[f, 1], normal[f, 2]
        for c in range(3):
            equations.area[F[f, c]] += area[f] / 12
            e = edge_of[3 * f + c]
            edge_area[e] += area[f] / 4
            a, b = edges[e, 0], edges[e, 1]
            w = NORMAL * area[f]
            add_outer(diagonal[a], x, y, z, w)
            add_outer(diagonal[b], x, y, z, w)
            add_outer(off_diagonal[e], x, y, z, -w)
            h = w * (x * (V[b, 0] - V[a, 0]) + y * (V[b, 1] - V[a, 1]) + z * (V[b, 2] - V[a, 2]))
            rhs[a, 0] += h * x
            rhs[a, 1] += h * y
            rhs[a, 2] += h * z
            rhs[b, 0] -= h * x
            rhs[b, 1] -= h * y
            rhs[b, 2] -= h * z


@compiled
def _add_planes(targets, equations, edge_area):
    """Add the terms of the vertices and of the middles of the edges to the equations; edge_area (e,): a_e."""
    (diagonal, off_diagonal, edges), rhs = equations.matrix, equations.rhs
    V, normals, area = targets.points, targets.normals, equations.area
    for v in range(len(V)):
        add_outer(diagonal[v], normals[v, 0], normals[v, 1], normals[v, 2], area[v])
    normals = targets.middle_normals
    for e in range(len(edges)):
        a, b = edges[e, 0], edges[e, 1]
        x, y, z = normals[e, 0], normals[e, 1], normals[e, 2]
        w = edge_area[e] / 4
        add_outer(diagonal[a], x, y, z, w)
        add_outer(diagonal[b], x, y, z, w)
        add_outer(off_diagonal[e], x, y, z, w)
        gap = 0.0
        for c in range(3):
            gap += normals[e, c] * (targets.middles[e, c] - (V[a, c] + V[b, c]) / 2)
        for c in range(3):
            rhs[a, c] += 2 * w * gap * normals[e, c]
            rhs[b, c] += 2 * w * gap * normals[e, c]


def _assemble(level: Level, targets: Targets, mapped: MappedFaces) -> NormalEquations:
    """The equations of all terms: the matrix is half the second derivative of E, the right-hand side half minus its gradient
    at the points of the map. 1e-15 more on the diagonal keeps it invertible where a vertex has no area."""
    n, e = level.n, len(level.edges)
    matrix = BlockMatrix(np.zeros((n, 6)), np.zeros((e, 6)), level.edges)
    equations, edge_area = NormalEquations(matrix, np.zeros((n, 3)), np.zeros(n)), np.zeros(e)
    _add_normals(level.F, level.edge_of, targets.points, mapped, equations, edge_area)
    _add_planes(targets, equations, edge_area)
    matrix.diagonal[:, DIAGONAL] += SPRING * equations.area[:, None] + 1e-15
    return equations


@compiled
def _stiffen(F, flipped, fixed, equations, spring, ring, vertices, numbers):
    """Stiffen the springs, spring (n,), at the corners of flipped faces, by STIFFER, and note what is to be solved for again.

    ring (n,) gets how many edges a vertex is away from those, plus 1; 0 from NEAR on. Returns how many vertices, in vertices
    (n,), and edges with a vertex near them, in numbers (e,), there are.
    """
    edges, diagonal = equations.matrix.edges, equations.matrix.diagonal
    for v in range(len(ring)):
        ring[v] = 0
    for f in range(len(F)):
        if not flipped[f]:
            continue
        for c in range(3):
            v = F[f, c]
            if ring[v] == 0:
                ring[v] = 1
                for d in DIAGONAL:
                    diagonal[v, d] += (STIFFER - 1) * spring[v] * equations.area[v]
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


def fit_to_surface(level: Level, points: np.ndarray, normals: np.ndarray, middles: np.ndarray, middle_normals: np.ndarray,
                   progress: Progress = no_progress) -> np.ndarray:
    """Fitted positions (n, 3) float64 of the vertices of a level: they minimise E, whose equation the module states.

    points (n, 3), p_v: those of the map for the vertices; middles (e, 3), p_e: for the middles of the level's edges; normals
    (n, 3), n_v, and middle_normals (e, 3), n_e: unit normals of the input faces that these lie on. All float64, in the unit
    frame. Raises whatever `progress` raises.
    """
    F, targets = level.F, Targets(points, normals, middles, middle_normals)
    mapped = MappedFaces(np.empty((len(F), 3)), np.empty(len(F)))
    _map_faces(F, level.edge_of, targets, np.empty((6, 3)), mapped)
    fixed = np.zeros(level.n, bool)
    fixed[F.reshape(-1)[level.opposite == np.arange(F.size)]] = True
    equations = _assemble(level, targets, mapped)
    n, e = level.n, len(level.edges)
    spring, x = np.full(n, SPRING), np.zeros((n, 3))
    flipped, ring, near, numbers = np.empty(len(F), bool), np.empty(n, np.int8), np.empty(n, np.int64), np.empty(e, np.int64)
    vertices, edges, least = np.flatnonzero(~fixed), np.arange(e), -1.0
    for done in range(ROUNDS):
        progress(done / ROUNDS, "Fitting the levels")
        least = conjugate_gradients(equations.matrix, equations.rhs, vertices, edges, x, least)
        X = points + x
        if not _find_flipped(F, X, mapped.normal, flipped):
            break
        some, edges_there = _stiffen(F, flipped, fixed, equations, spring, ring, near, numbers)
        vertices, edges = near[:some], numbers[:edges_there]
    return X


@compiled
def _go_back(F, S, X, N, V, share, moved, looked):
    """Bring V, which is X, back towards S until no face of F is flipped against the normals N that is not flipped at S; share
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
            if not is_flipped(F, V, N, f, OPPOSED) or is_flipped(F, S, N, f, OPPOSED):
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
    """Fitted positions (n, 3) float64, some moved back towards the points of the map (n, 3): V_v = S_v + s_v (X_v - S_v), with
    s_v = 1, 1/2, 1/4, 1/8 or 0.

    No face of levels 1..L is then flipped (OPPOSED, see `face_orientation`) against its corners' normals (n, 3) that is not
    flipped at the points of the map.
    """
    F = np.concatenate([level.F for level in levels[1:]])
    V = fitted.copy()
    _go_back(F, points, fitted, normals, V, np.ones(len(V)), np.zeros(len(V), np.int64), np.zeros(len(F), np.int64))
    return V
