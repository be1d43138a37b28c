"""The vertices of M^1..M^L are moved over the input surface until no face is folded over, or the work allowed is done.

The map is a bijection, but a face through three of its points can still oppose the surface where the map is strongly
bent or the part is thinner than the face. Base vertices that lie far from their position return to it (see `base_vertices`),
single vertices of flipped faces move over the surface (see `vertex_moves`), then what that leaves is perturbed (see
`perturbation`). A step counts over all levels that hold the vertex. The method is ours.
"""
import numpy as np

from ..geometry import FLIPPED_SURFACE, SurfacePoints, TraceMesh, is_flipped
from ..jit import compiled
from ..mesh import Level
from ..parallel import each
from ..progress import Progress, no_progress
from .base_vertices import return_to_base_positions
from .one_rings import one_rings_of
from .parallel_trials import ParallelTrials
from .perturbation import relocate_corners
from .propagation import to_midpoint
from .trial import MARK, TIME, WORK_LEFT, TrialRegion, begin, changed

PASSES = 12
RETURNS = 3  # rounds in which base vertices return to their positions
# trials for a face, and the share of the projected area that is to stay: what keeps it is tried first
ROUNDS = ((4, 0.97), (8, 0.97), (16, 0.95), (32, 0.9), (64, 0.85), (96, 0.8), (128, 0.8))
WORK = 20_000_000  # see `trial.WORK_LEFT`: bounds the time that a hopeless mesh takes, 10 to 20 s
SLICE = 100_000  # of it between two calls of `progress`: some tenths of a second
EDGES = 10_000  # edges whose middles one thread looks at
TOGETHER = 16  # flipped faces between two calls, at most: tenths of a second
BASE_SLICE = 100  # base vertices between two calls
MESSAGE = "Unfolding the levels"


@compiled
def _to_midpoints(surface, points, start, edges, first, last, tried, found):
    """Put the points behind the vertices, which halve `edges` (e, 2), back on the middle of edges first..last - 1 whose ends
    moved from `start` (n, 3). tried (3,), found (3,): work space."""
    P, n = points.P, len(points.P) - len(edges)
    for e in range(first, last):
        i, j = edges[e, 0], edges[e, 1]
        moved = False
        for c in range(3):
            moved |= P[i, c] != start[i, c] or P[j, c] != start[j, c]
        if moved:
            to_midpoint(surface, points, n + e, i, j, tried, found)


@compiled
def _flipped(rings, points, out):
    """The numbers of the flipped faces, in out (m,); returns how many there are."""
    count = 0
    for f in range(len(rings.F)):
        if is_flipped(rings.F, points.P, points.N, f, FLIPPED_SURFACE):
            out[count] = f
            count += 1
    return count


@compiled
def _add_flipped(rings, points, f, region, out, count):
    """Add face f to those in out, if it is flipped and was not looked at; returns how many there are."""
    if region.seen[f] != region.state[MARK]:
        region.seen[f] = region.state[MARK]
        if is_flipped(rings.F, points.P, points.N, f, FLIPPED_SURFACE):
            out[count] = f
            count += 1
    return count


@compiled
def _still_flipped(rings, points, before, since, region, out):
    """As `_flipped`, in any order, where `before` (k,) were flipped at the time `since`: a face that no corner of moved since has
    not changed."""
    begin(region)
    count = 0
    for f in before:
        count = _add_flipped(rings, points, f, region, out, count)
    for v in range(len(rings.parents)):
        if region.times.moved[v] > since:
            for level in range(len(rings.at)):
                for k in range(rings.at[level, v], rings.at[level, v + 1]):
                    count = _add_flipped(rings, points, rings.faces[k], region, out, count)
    return count


@compiled
def _relocate_slice(surface, rings, points, faces, start, most, region, covered):
    """Relocate single vertices of those of the faces that are flipped, from place `start` on, until that took `most` work.

    Returns the next place, and whether a vertex moved.
    """
    level, moved = 0, False
    least = region.state[WORK_LEFT] - most
    for k in range(start, len(faces)):
        f = faces[k]
        while f >= rings.first[level + 1]:
            level += 1
        if not is_flipped(rings.F, points.P, points.N, f, FLIPPED_SURFACE):
            continue
        if not changed(rings, f, region.times.steps[f], region.times.moved):
            continue
        region.state[TIME] += 1
        region.times.steps[f] = region.state[TIME]
        moved |= relocate_corners(surface, rings, points, f, level, region, False, True, covered)
        if region.state[WORK_LEFT] <= least:
            return k + 1, moved
    return len(faces), moved


class _Untangling:
    """The flipped faces of the points on a surface, in rising order, and two ways to turn some of them back; each way returns
    whether a vertex moved, and after it `update` looks for what is still flipped."""

    def __init__(self, surface: TraceMesh, points: SurfacePoints, levels: list[Level], progress: Progress) -> None:
        self.surface, self.points, self.rings, self.progress = surface, points, one_rings_of(levels), progress
        self.region = TrialRegion.make(len(points.P), len(self.rings.F), len(self.rings.at), WORK)
        self.faces, self.listed = np.empty(0, np.int64), 0  # the time up to which they are known
        self._room = np.empty(len(self.rings.F), np.int64)

    def _may_go_on(self) -> bool:
        """Whether work is left; reports progress if so."""
        left = self.region.work_left
        if left > 0:
            self.progress(1 - left / WORK, MESSAGE)
        return left > 0

    def return_base(self, base: np.ndarray) -> bool:
        """Move base vertices that lie far from their positions base (n0, 3) towards them."""
        done = 0
        for first in range(0, len(base), BASE_SLICE):
            self.progress(0.0, MESSAGE)
            done += return_to_base_positions(self.surface, self.rings, self.points, base, first, first + BASE_SLICE, self.region)
        return done > 0

    def find_all(self) -> None:
        """Look at every face."""
        count = _flipped(self.rings, self.points, self._room)
        self.faces, self.listed = self._room[:count].copy(), self.region.time

    def update(self) -> None:
        """Look again at the faces that were flipped, and at those round what moved since."""
        since, self.listed = self.listed, self.region.time
        count = _still_flipped(self.rings, self.points, self.faces, since, self.region, self._room)
        self.faces = np.sort(self._room[:count])

    def relocate(self, covered: float) -> bool:
        """Relocate corners of the flipped faces, one vertex at a time, in slices of work."""
        place, moved = 0, False
        while place < len(self.faces) and self._may_go_on():
            place, some = _relocate_slice(self.surface, self.rings, self.points, self.faces, place, SLICE, self.region, covered)
            moved |= some
        return moved

    def perturb(self, trials: int, covered: float, parallel: ParallelTrials) -> bool:
        """Perturb the flipped faces, some at a time."""
        place, moved = 0, False
        while place < len(self.faces) and self._may_go_on():
            better = parallel.try_perturbations(self.faces[place:place + TOGETHER], trials, covered)
            moved |= better >= 0
            place += better + 1 if better >= 0 else TOGETHER
        return moved

    def parallel(self) -> ParallelTrials:
        """The threads that `perturb` needs; a context."""
        return ParallelTrials(self.surface, self.rings, self.points, self.region, ROUNDS[-1][0])


def untangle(surface: TraceMesh, points: SurfacePoints, levels: list[Level], base: np.ndarray,
             progress: Progress = no_progress) -> None:
    """Move points on a surface so that fewer faces of the levels through them are flipped (FLIPPED_SURFACE); changes points.

    surface: the input. points: the first n are the vertices of the finest of `levels` (0..L, of a hierarchy); the rest, which may
    be missing, the middles of its edges: they follow ends that moved. base (n0, 3) float64: the base vertices' own positions, in
    the surface's frame. Border vertices stay. Deterministic on any number of threads, in bounded time. Raises whatever `progress`
    raises. The method is ours.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import TraceMesh, move_point, points_on, vertex_normals
    >>> from npm_blender.core.mesh import TriMesh, hierarchy, midpoints, opposite_halfedges
    >>> from npm_blender.core.untangling import untangle
    >>> mesh = TriMesh.from_arrays([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    >>> surface = TraceMesh(mesh.V, mesh.F, opposite_halfedges(mesh.F), vertex_normals(mesh))
    >>> levels = hierarchy(mesh.F, 3, 2)  # the triangle subdivided, with three vertices inside
    >>> points = points_on(surface, np.zeros(15, np.int32), midpoints(midpoints(np.eye(3), levels[0]), levels[1]))
    >>> move_point(surface, points, 12, 0, np.array([0.1, 0.1, 0.8]))  # from (1, 1, 0), over its neighbours
    >>> untangle(surface, points, levels, mesh.V)
    >>> points.P[12].tolist()
    [1.0, 1.0, 0.0]
    """
    state, start = _Untangling(surface, points, levels, progress), points.P.copy()
    for _ in range(RETURNS):
        if not state.return_base(base):
            break
    state.find_all()
    with state.parallel() as parallel:
        for trials, covered in ROUNDS:
            for _ in range(PASSES):
                if not state.relocate(covered):
                    break
                state.update()
            if state.perturb(trials, covered, parallel):
                state.update()
    edges = levels[-1].edges[:len(start) - levels[-1].n]

    def task(first: int) -> None:
        _to_midpoints(surface, points, start, edges, first, min(first + EDGES, len(edges)), np.empty(3), np.empty(3))

    each(task, range(0, len(edges), EDGES))
