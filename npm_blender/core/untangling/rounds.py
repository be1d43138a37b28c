"""Local relaxation of the vertices of M^1..M^L on the input surface: unfolds faces that the sampling has turned over.

The map is a bijection, but a face through three of its points can still oppose the surface where the map is strongly
bent or the part is thinner than the face. Base vertices that lie far from their place walk home (see `home`), single
vertices of turned faces walk over the surface (see `unfold`), then what that leaves is shaken (see `shake`). A step counts
over all levels that hold the vertex.
"""
import numpy as np

from ..geometry import SurfacePoints, TraceMesh, is_flipped
from ..jit import compiled
from ..mesh import Level
from ..parallel import each
from ..progress import Progress, no_progress
from .base_vertices import return_to_base_positions
from .one_rings import one_rings_of
from .parallel_trials import ParallelTrials
from .perturbation import mend
from .propagation import to_midpoint
from .trial import TrialRegion, changed

PASSES = 12
HOME = 3  # rounds in which base vertices walk home
# trials for a face, and the share of the projected area that is to stay: what keeps it is tried first
ROUNDS = ((4, 0.97), (8, 0.97), (16, 0.95), (32, 0.9), (64, 0.85), (96, 0.8), (128, 0.8))
WORK = 20_000_000  # see `patch.TrialRegion`: bounds the time that a hopeless mesh takes, 10 to 20 s
SLICE = 100_000  # of it between two calls of `progress`: some tenths of a second
EDGES = 10_000  # edges whose middles one thread looks at
TOGETHER = 16  # turned faces between two calls, at most: tenths of a second
HOME_SLICE = 100  # base vertices between two calls
MESSAGE = "Unfolding the levels"


@compiled
def _halve(surface, points, start, edges, first, last, w, where):
    """Put the points behind the vertices, which halve `edges` (e, 2), back on the middle of edges first..last - 1 whose ends
    moved. w (3,), where (3,): work space."""
    P, n = points.P, len(points.P) - len(edges)
    for e in range(first, last):
        i, j = edges[e, 0], edges[e, 1]
        moved = False
        for c in range(3):
            moved |= P[i, c] != start[i, c] or P[j, c] != start[j, c]
        if moved:
            to_midpoint(surface, points, n + e, i, j, w, where)


@compiled
def _turned(rings, points, out):
    """The numbers of the turned faces, in out (m,); returns how many there are."""
    count = 0
    for f in range(len(rings.F)):
        if is_flipped(rings.F, points.P, points.N, f):
            out[count] = f
            count += 1
    return count


@compiled
def _add_turned(rings, points, f, patch, out, count):
    """Add face f to those in out, if it is turned and was not looked at; returns how many there are."""
    if patch.seen[f] != patch.state[0]:
        patch.seen[f] = patch.state[0]
        if is_flipped(rings.F, points.P, points.N, f):
            out[count] = f
            count += 1
    return count


@compiled
def _still_turned(rings, points, before, since, patch, out):
    """As `_turned`, in any order, where `before` (k,) were turned at the time `since`: a face that no corner of moved since has
    not changed."""
    patch.state[0] += 1
    count = 0
    for f in before:
        count = _add_turned(rings, points, f, patch, out, count)
    for v in range(len(rings.parents)):
        if patch.moved[v] > since:
            for level in range(len(rings.at)):
                for k in range(rings.at[level, v], rings.at[level, v + 1]):
                    count = _add_turned(rings, points, rings.faces[k], patch, out, count)
    return count


@compiled
def _steps(surface, rings, points, faces, at, most, patch, covered):
    """Improve single vertices of those of the faces that are turned, from place `at` on, until that took `most` work.

    Returns the next place, and whether a vertex moved.
    """
    level, moved = 0, False
    least = patch.state[2] - most
    for k in range(at, len(faces)):
        f = faces[k]
        while f >= rings.first[level + 1]:
            level += 1
        if not is_flipped(rings.F, points.P, points.N, f) or not changed(rings, f, patch.failed[f], patch.moved):
            continue
        patch.state[3] += 1
        patch.failed[f] = patch.state[3]
        if mend(surface, rings, points, f, level, patch, False, patch.moved, patch.state[3], True, covered):
            moved = True
        if patch.state[2] <= least:
            return k + 1, moved
    return len(faces), moved


def untangle(surface: TraceMesh, points: SurfacePoints, levels: list[Level], home: np.ndarray,
             progress: Progress = no_progress) -> None:
    """Move the points on the surface so that fewer faces of the levels through them are turned over; changes points.

    The first n points are the vertices of the finest of `levels`; the rest, which may be missing, the middles of its
    edges: they follow ends that moved. home (n0, 3): the base vertices. Border vertices stay.
    Deterministic, in bounded time. Raises whatever `progress` raises.
    """
    rings = one_rings_of(levels)
    patch = TrialRegion.make(len(points.P), len(rings.F), len(rings.at), WORK)
    start = points.P.copy()
    for _ in range(HOME):
        done = 0
        for at in range(0, len(home), HOME_SLICE):
            progress(0.0, MESSAGE)
            done += return_to_base_positions(surface, rings, points, home, at, at + HOME_SLICE, patch)
        if not done:
            break

    room = np.empty(len(rings.F), np.int64)

    def still_turned() -> np.ndarray:
        nonlocal listed
        since, listed = listed, patch.state[3]
        return np.sort(room[:_still_turned(rings, points, faces, since, patch, room)])

    def steps(faces: np.ndarray, covered: float) -> bool:
        """Improve the corners of turned faces, in slices; whether a vertex moved."""
        at, moved = 0, False
        while at < len(faces) and patch.state[2] > 0:
            progress(1 - patch.state[2] / WORK, MESSAGE)
            at, now = _steps(surface, rings, points, faces, at, SLICE, patch, covered)
            moved |= now
        return moved

    def shakes(faces: np.ndarray, trials: int, covered: float) -> bool:
        """Shake the faces that are turned; whether a vertex moved."""
        at, moved = 0, False
        while at < len(faces) and patch.state[2] > 0:
            progress(1 - patch.state[2] / WORK, MESSAGE)
            better = shakers.shake(faces[at:at + TOGETHER], trials, covered)
            moved |= better >= 0
            at += better + 1 if better >= 0 else TOGETHER
        return moved

    faces, listed = room[:_turned(rings, points, room)].copy(), patch.state[3]
    with ParallelTrials(surface, rings, points, patch, ROUNDS[-1][0]) as shakers:
        for trials, covered in ROUNDS:
            for _ in range(PASSES):
                if not steps(faces, covered):
                    break
                faces = still_turned()
            if shakes(faces, trials, covered):
                faces = still_turned()
    edges = levels[-1].edges[:len(start) - levels[-1].n]

    def task(first: int) -> None:
        _halve(surface, points, start, edges, first, min(first + EDGES, len(edges)), np.empty(3), np.empty(3))

    each(task, range(0, len(edges), EDGES))
