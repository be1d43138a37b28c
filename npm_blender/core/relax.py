"""Local relaxation of the vertices of M^1..M^L on the input surface: unfolds faces that the sampling has turned over.

The map is a bijection, but a face through three of its points can still oppose the surface where the map is strongly
bent or the part is thinner than the face. Base vertices that lie far from their place walk home (see `home`), single
vertices of turned faces walk over the surface (see `unfold`), then what that leaves is shaken (see `shake`). A step counts
over all levels that hold the vertex.
"""
import numpy as np

from .home import go_home
from .jit import compiled
from .patch import Patch, changed, halve
from .progress import Progress, no_progress
from .shake import shake
from .subdivide import Level
from .unfold import MARGIN, Rings, cosine, improve
from .walk import Points, Surface

PASSES = 12
HOME = 3  # rounds in which base vertices walk home
# trials for a face, and the share of the projected area that is to stay: what keeps it is tried first
ROUNDS = ((4, 0.97), (8, 0.97), (16, 0.95), (24, 0.9), (32, 0.8))
WORK = 3_000_000  # vertices that trials of shaking may move, in all: bounds the time that a hopeless mesh takes
SLICE = 5000  # of them between two calls of `progress`: some tenths of a second
HOME_SLICE = 100  # base vertices between two calls
MESSAGE = "Unfolding the levels"


def rings_of(levels: list[Level]) -> Rings:
    """The rings of levels 1..L of a hierarchy; border vertices are fixed."""
    n = np.array([level.n for level in levels])
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
    return Rings(np.concatenate([level.F for level in levels]), np.concatenate(opposite), first, out, fixed, n)


@compiled
def _halve(surface, points, start, edges, patch):
    """Put the points behind the vertices, which halve `edges` (e, 2), back on the middle of edges whose ends moved."""
    P, n = points.P, len(points.P) - len(edges)
    for e in range(len(edges)):
        i, j = edges[e]
        moved = False
        for c in range(3):
            moved |= P[i, c] != start[i, c] or P[j, c] != start[j, c]
        if moved:
            halve(surface, points, n + e, i, j, patch.w, patch.where)


@compiled
def _steps(surface, rings, points, levels, passes, patch, covered):
    """Improve single vertices of turned faces until nothing moves."""
    for _ in range(passes):
        moved = False
        for level in range(levels):
            for f in range(rings.first[level], rings.first[level + 1]):
                if cosine(rings.F, points.P, points.N, f) > MARGIN or not changed(rings, f, patch):
                    continue
                patch.state[3] += 1
                patch.failed[f] = patch.state[3]
                for c in range(3):
                    if cosine(rings.F, points.P, points.N, f) > MARGIN:
                        break
                    v = rings.F[f, c]
                    if not rings.fixed[v] and improve(surface, rings, points, f, c, level, levels, patch.w,
                                                      patch.best, patch.where, True, covered):
                        patch.moved[v] = patch.state[3]
                        moved = True
        if not moved:
            break


@compiled
def _shakes(surface, rings, points, at, most, trials, patch, covered):
    """Shake the turned faces from number `at` on until `most` vertices moved; the number of the next face, or that of all."""
    levels, level = len(rings.out), 0
    least = patch.state[2] - most
    for f in range(at, rings.first[levels]):
        while f >= rings.first[level + 1]:
            level += 1
        if cosine(rings.F, points.P, points.N, f) <= MARGIN:
            shake(surface, rings, points, f, level, levels, trials, patch, covered)
            if patch.state[2] <= least:
                return f + 1
    return rings.first[levels]


def relax(surface: Surface, points: Points, levels: list[Level], home: np.ndarray, progress: Progress = no_progress) -> None:
    """Move the points on the surface so that fewer faces of the levels through them are turned over; changes points.

    The first n points are the vertices of the finest of `levels`; the rest, which may be missing, the middles of its
    edges: they follow ends that moved. home (n0, 3): the base vertices. Border vertices stay.
    Deterministic, in bounded time. Raises whatever `progress` raises.
    """
    rings = rings_of(levels)
    patch = Patch.make(len(points.P), len(rings.F), len(rings.out), WORK)
    start = points.P.copy()
    for _ in range(HOME):
        done = 0
        for at in range(0, len(home), HOME_SLICE):
            progress(0.0, MESSAGE)
            done += go_home(surface, rings, points, home, at, at + HOME_SLICE, patch)
        if not done:
            break
    for trials, covered in ROUNDS:
        _steps(surface, rings, points, len(rings.out), PASSES, patch, covered)
        at = 0
        while at < len(rings.F) and patch.state[2] > 0:
            progress(1 - patch.state[2] / WORK, MESSAGE)
            at = _shakes(surface, rings, points, at, SLICE, trials, patch, covered)
    _halve(surface, points, start, levels[-1].edges[:len(start) - levels[-1].n], patch)
