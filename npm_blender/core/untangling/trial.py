"""Several vertices of the levels moved at once, on trial: what moves, what lies round it, whether that is better.

A trial moves some vertices of one level; the finer vertices round them follow to the middles of their edges (see
`propagate`), or a coarse face could never be turned back without folding its own subdivision. Which vertices and faces these
are depends on connectivity alone, so a region is gathered once for many trials. A trial is kept if it is better
(see `better`), else everything goes back to where it was. The method is ours.
"""
from typing import NamedTuple

import numpy as np

from ..geometry import FLIPPED_SURFACE, is_flipped, not_flipped, orientation_measures
from ..jit import compiled
from .vertex_moves import PlaceSearch

_VERTICES, _FACES = 24, 64  # room for vertices and faces of a region, times 4^L
SMOOTHED = 4  # widths of a region that is smoothed (see `trial_schedule`)

# Places in TrialRegion.state (5,) int64. MARK: the number that marks the vertices and faces of the present region; RANDOM: the
# generator's state; WORK_LEFT: in vertices moved, and some more for each that single steps relocate; TIME: counts what
# happened for good, and dates FailureTimes; TRIAL_TIME: the same within trials, for TrialTimes.
MARK, RANDOM, WORK_LEFT, TIME, TRIAL_TIME = range(5)


class Saved(NamedTuple):
    """Where the vertices of a region were, a row each: face (k,) int32, barycentrics b, position P and normal N (k, 3)."""

    face: np.ndarray
    b: np.ndarray
    P: np.ndarray
    N: np.ndarray


class FailureTimes(NamedTuple):
    """When something last moved or failed for good (0: never): what failed is not tried again before something near it moved.

    moved (n,): when each vertex moved; steps (m,): when moves of single corners failed at a face; base (n,): when a base vertex
    could not return to its position; smoothing (m, SMOOTHED): when smoothing a face with so many rings round it failed.
    """

    moved: np.ndarray
    steps: np.ndarray
    base: np.ndarray
    smoothing: np.ndarray


class TrialTimes(NamedTuple):
    """`moved` (n,) and `steps` (m,) as in FailureTimes, within a trial that may still be undone."""

    moved: np.ndarray
    steps: np.ndarray


class TrialRegion(NamedTuple):
    """The vertices and faces that a trial moves, and what is remembered between trials. All numbers are int64.

    vertices, faces: those of the region, coarse before fine, of which the first vertices_to[k] and faces_to[k] are of level k + 1
    and those before it; mark (n,), seen (m,): state[MARK] for the vertices and faces of the region.
    state: see MARK, RANDOM, WORK_LEFT, TIME, TRIAL_TIME; search: work space for the place of one vertex.
    """

    vertices: np.ndarray
    faces: np.ndarray
    vertices_to: np.ndarray
    faces_to: np.ndarray
    mark: np.ndarray
    seen: np.ndarray
    saved: Saved
    times: FailureTimes
    trial_times: TrialTimes
    search: PlaceSearch
    state: np.ndarray

    @staticmethod
    def make(vertices: int, faces: int, levels: int, work: int) -> "TrialRegion":
        """An empty region for that many points and faces of all levels together; work: what state[WORK_LEFT] starts with."""
        room = _VERTICES * 4**levels

        def zeros(*size: int) -> np.ndarray:
            return np.zeros(size, np.int64)

        return TrialRegion(
            zeros(room), zeros(_FACES * 4**levels), zeros(levels), zeros(levels), zeros(vertices), zeros(faces),
            Saved(np.zeros(room, np.int32), np.zeros((room, 3)), np.zeros((room, 3)), np.zeros((room, 3))),
            FailureTimes(zeros(vertices), zeros(faces), zeros(vertices), zeros(faces, SMOOTHED)),
            TrialTimes(zeros(vertices), zeros(faces)), PlaceSearch.make(), np.array([0, 1, work, 0, 0]))

    def another(self) -> "TrialRegion":
        """A region for another thread, which shares the times of what moved or failed for good, and starts with a copy of the
        state."""
        other = TrialRegion.make(len(self.mark), len(self.seen), len(self.vertices_to), 0)
        return other._replace(times=self.times, state=self.state.copy())

    @property
    def work_left(self) -> int:
        """How much work may still be done."""
        return int(self.state[WORK_LEFT])

    @property
    def time(self) -> int:
        """The time that `times` count in."""
        return int(self.state[TIME])

    def set_work(self, work: int) -> None:
        """Allow so much work from now on."""
        self.state[WORK_LEFT] = work


class Fitness(NamedTuple):
    """Of a region's faces, how many are flipped; of the finest ones, the summed bulge, and the summed area projected on the
    surface, from which flipped faces take away (times 6; see `orientation_measures`)."""

    flipped: int
    bulge: float
    area: float


@compiled
def changed(rings, f, last, moved):
    """Whether anything round face f moved since the time `last` (0: never) at which single steps failed at it: if not,
    they would fail again. moved (n,): when each vertex did."""
    if last == 0:
        return True
    for c in range(3):
        v = rings.F[f, c]
        if moved[v] >= last:
            return True
        for level in range(len(rings.at)):
            for k in range(rings.at[level, v], rings.at[level, v + 1]):
                if moved[rings.around[k]] >= last:
                    return True
    return False


@compiled
def begin(region):
    """Start a new region, without vertices."""
    region.state[MARK] += 1


@compiled
def add(v, region, count):
    """Make v one of the region's vertices, of which there are `count`; returns the new count."""
    region.mark[v] = region.state[MARK]
    region.vertices[count] = v
    return count + 1


@compiled
def add_neighbours(rings, level, v, region, count):
    """Add the free neighbours of v at a level; returns the new count, that of the room if it does not suffice."""
    for k in range(rings.at[level, v], rings.at[level, v + 1]):
        x = rings.around[k]
        if region.mark[x] != region.state[MARK] and not rings.fixed[x]:
            if count == len(region.vertices):
                return count
            count = add(x, region, count)
    return count


@compiled
def gather(rings, level, region, count):
    """Complete a region, which so far has `count` vertices of a level (-1: of the base): add the finer vertices that follow
    them and the faces round all, of each level.

    Returns how many vertices there are, or 0 if the room does not suffice.
    """
    levels, found = len(rings.at), 0
    for k in range(levels):
        if k > level:
            for i in range(count):
                if region.vertices[i] < rings.n[k]:
                    count = add_neighbours(rings, k, region.vertices[i], region, count)
        region.vertices_to[k] = count
        if count == len(region.vertices):
            return 0
    for k in range(levels):
        for i in range(region.vertices_to[k]):
            v = region.vertices[i]
            for j in range(rings.at[k, v], rings.at[k, v + 1]):
                f = rings.faces[j]
                if region.seen[f] != region.state[MARK]:
                    if found == len(region.faces):
                        return 0
                    region.seen[f] = region.state[MARK]
                    region.faces[found] = f
                    found += 1
        region.faces_to[k] = found
    return count


@compiled
def count_flipped(rings, points, region, first, end, most):
    """How many of the region's faces first..end - 1, by their place in it, are flipped; more than `most` are not counted."""
    out = 0
    for i in range(first, end):
        if is_flipped(rings.F, points.P, points.N, region.faces[i], FLIPPED_SURFACE):
            out += 1
            if out > most:
                break
    return out


@compiled
def fitness(rings, points, region):
    """The Fitness of the region."""
    levels, height, area = len(rings.at), 0.0, 0.0
    finest = region.faces_to[levels - 2] if levels > 1 else 0
    out = count_flipped(rings, points, region, 0, finest, finest)
    for i in range(finest, region.faces_to[levels - 1]):
        f = region.faces[i]
        product, size, bulge = orientation_measures(points.P, points.N, rings.F[f, 0], rings.F[f, 1], rings.F[f, 2])
        height += bulge
        area += product
        out += not not_flipped(product, size, FLIPPED_SURFACE)
    return Fitness(out, height, area)


@compiled
def better(rings, points, region, before, most, farther, covered):
    """Whether at most `most` of the region's faces are flipped, with at most `farther` times the bulge that there was before, and
    at least `covered` times the area; before: a Fitness."""
    if count_flipped(rings, points, region, 0, region.faces_to[len(rings.at) - 1], most) > most:
        return False
    after = fitness(rings, points, region)
    return after.bulge <= farther * before.bulge + 1e-15 and after.area >= covered * before.area


@compiled
def save(points, region, count):
    """Note in `saved` where the region's first `count` vertices are."""
    saved = region.saved
    for i in range(count):
        v = region.vertices[i]
        saved.face[i] = points.face[v]
        for c in range(3):
            saved.b[i, c], saved.P[i, c], saved.N[i, c] = points.b[v, c], points.P[v, c], points.N[v, c]


@compiled
def restore(points, region, count):
    """Put the region's first `count` vertices back where they were saved."""
    saved = region.saved
    for i in range(count):
        v = region.vertices[i]
        points.face[v] = saved.face[i]
        for c in range(3):
            points.b[v, c], points.P[v, c], points.N[v, c] = saved.b[i, c], saved.P[i, c], saved.N[i, c]


@compiled
def commit(region, count):
    """Note that the region's first `count` vertices moved for good."""
    region.state[TIME] += 1
    for i in range(count):
        region.times.moved[region.vertices[i]] = region.state[TIME]
