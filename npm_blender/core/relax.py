"""Local relaxation of the vertices of M^1..M^L on the input surface: unfolds faces that the sampling has turned over.

The map is a bijection, but a face through three of its points can still oppose the surface where the map is strongly
bent or the part is thinner than the face. Single vertices of turned faces walk over the surface (see `unfold`), then what
that leaves is shaken (see `shake`). A step counts over all levels that hold the vertex.
"""
import numpy as np

from .jit import compiled
from .mesh import TriMesh
from .progress import Progress, no_progress
from .shake import Work, changed, shake
from .subdivide import Level
from .unfold import MARGIN, Rings, cosine, improve
from .walk import Points, Surface, move, show, walk

PASSES = 12
SHAKES = (4, 8, 16)  # trials for a face, in the rounds of shaking
TRIALS = 4000  # of shaking in all: bounds the time that a hopeless mesh takes
SLICE = 100  # trials between two calls of `progress`, some tenths of a second at most
MESSAGE = "Unfolding the levels"


def rings_of(levels: list[Level]) -> Rings:
    """The rings of levels 1..L of a hierarchy; border vertices are fixed."""
    levels = levels[1:]
    first = np.cumsum([0] + [len(level.F) for level in levels])
    out = np.full((len(levels), levels[-1].n), -1, np.int64)
    opposite = []
    for k, level in enumerate(levels):
        out[k, level.F.reshape(-1)] = np.arange(level.F.size) + 3 * first[k]
        opposite.append(level.opposite.astype(np.int64) + 3 * first[k])
    fixed = np.zeros(levels[-1].n, bool)
    last = levels[-1]
    border = np.flatnonzero(last.opposite == np.arange(last.F.size))
    fixed[last.F.reshape(-1)[border]] = True
    return Rings(np.concatenate([level.F for level in levels]), np.concatenate(opposite), first, out, fixed)


@compiled
def _halve(surface, rings, points, start, edges, w, u):
    """Put the points behind the vertices, which halve `edges` (e, 2), back on the middle of edges whose ends moved."""
    P, n = points.P, rings.out.shape[1]
    for e in range(len(edges)):
        i, j = edges[e]
        moved = False
        for c in range(3):
            moved |= P[i, c] != start[i, c] or P[j, c] != start[j, c]
        if not moved:
            continue
        mx, my, mz = (P[i, 0] + P[j, 0]) / 2, (P[i, 1] + P[j, 1]) / 2, (P[i, 2] + P[j, 2]) / 2
        nearest, face = np.inf, -1
        for trial in range(3):
            v = n + e if trial == 0 else (i if trial == 1 else j)
            w[0], w[1], w[2] = points.b[v, 0], points.b[v, 1], points.b[v, 2]
            x, y, z = mx - start[v, 0], my - start[v, 1], mz - start[v, 2]
            if trial > 0:
                x, y, z = mx - P[v, 0], my - P[v, 1], mz - P[v, 2]
            g = walk(surface, points.face[v], w, x, y, z)
            show(surface, points, n + e, g, w)
            gap = (P[n + e, 0] - mx) ** 2 + (P[n + e, 1] - my) ** 2 + (P[n + e, 2] - mz) ** 2
            if gap < nearest:
                nearest, face = gap, g
                u[0], u[1], u[2] = w[0], w[1], w[2]
        move(surface, points, n + e, face, u)


@compiled
def _steps(surface, rings, points, levels, passes, work):
    """Improve single vertices of turned faces of the first `levels` levels until nothing moves."""
    for _ in range(passes):
        moved = False
        for level in range(levels):
            for f in range(rings.first[level], rings.first[level + 1]):
                if cosine(rings.F, points.P, points.N, f) > MARGIN or not changed(rings, f, work):
                    continue
                work.state[3] += 1
                work.tried[f] = work.state[3]
                for c in range(3):
                    if cosine(rings.F, points.P, points.N, f) > MARGIN:
                        break
                    v = rings.F[f, c]
                    if not rings.fixed[v] and improve(surface, rings, points, f, c, level, levels, work.w, work.best,
                                                      work.where, True):
                        work.moved[v] = work.state[3]
                        moved = True
        if not moved:
            break


@compiled
def _shakes(surface, rings, points, at, most, trials, work):
    """Shake the turned faces from number `at` on, `most` trials at most; the number of the next face, or that of all."""
    levels, level = len(rings.out), 0
    least = work.state[2] - most
    for f in range(at, rings.first[levels]):
        while f >= rings.first[level + 1]:
            level += 1
        if cosine(rings.F, points.P, points.N, f) <= MARGIN:
            shake(surface, rings, points, f, level, levels, trials, work)
            if work.state[2] <= least:
                return f + 1
    return rings.first[levels]


def relax(mesh: TriMesh, opposite: np.ndarray, normals: np.ndarray, levels: list[Level], face: np.ndarray,
          barycentric: np.ndarray, progress: Progress = no_progress) -> tuple[np.ndarray, np.ndarray]:
    """Relaxed points (face (n + e,) int32, barycentric (n + e, 3)) on the mesh of the finest of `levels`.

    The first n are its vertices; the rest, which may be missing, the middles of its edges: they follow ends that moved.
    opposite (3 m,): opposite half-edges of the mesh; normals (n, 3): its vertex normals. Border vertices stay.
    Deterministic, in bounded time. Raises whatever `progress` raises.
    """
    surface = Surface(mesh.V, mesh.F, opposite, normals)
    face, b = face.copy(), barycentric.copy()
    at = mesh.F[face]
    P = np.einsum("nk,nkd->nd", b, mesh.V[at])
    N = np.einsum("nk,nkd->nd", b, normals[at])
    N /= np.linalg.norm(N, axis=1, keepdims=True) + 1e-300
    rings = rings_of(levels)
    work = Work.make(len(P), len(rings.F))
    points, start = Points(face, b, P, N), P.copy()
    work.state[2] = TRIALS
    for trials in SHAKES:
        _steps(surface, rings, points, len(rings.out), PASSES, work)
        at = 0
        while at < len(rings.F) and work.state[2] > 0:
            progress(1 - work.state[2] / TRIALS, MESSAGE)
            at = _shakes(surface, rings, points, at, SLICE, trials, work)
    _halve(surface, rings, points, start, levels[-1].edges[:len(face) - levels[-1].n], work.w, work.where)
    return face, b
