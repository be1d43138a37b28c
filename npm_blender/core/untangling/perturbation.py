"""A flipped face that no step of a single vertex turns back: its surroundings are smoothed, or moved at random, and single
vertices are relocated from there.

Kept is what leaves fewer flipped faces, over all levels, and is no worse otherwise (see `trial.better`); else everything
goes back to where it was (see `trial_schedule`, which also says which tries are made). The method is ours.
"""
from typing import NamedTuple

import numpy as np

from ..geometry import FLIPPED_SURFACE, is_flipped, move_point, trace_geodesic
from ..jit import compiled
from .propagation import propagate
from .trial import MARK, RANDOM, TIME, TRIAL_TIME, WORK_LEFT, better, changed, count_flipped
from .vertex_moves import FARTHER, middle, relocate_vertex

SMOOTH = 2  # steps of smoothing
LEAST = 0.15  # random step of the first trial, in mean lengths of the face's sides; of the last: 1
SWEEPS = 4
WORSE, WORSE_OF = 10, 16  # a try that flips so many faces more than before, or one in so many of the region's, is given up
STEP = 5  # work of relocating a vertex, in vertices moved
MULTIPLIER, INCREMENT = 6364136223846793005, 1442695040888963407  # of the random numbers (Knuth's MMIX)


class Effort(NamedTuple):
    """How hard a face is tried: with less than `trials` random steps, numbered from 1 on, for a place that keeps the share
    `covered` of the projected area."""

    trials: int
    covered: float


@compiled
def _size(F, P, f):
    """Root of the mean squared side of face f."""
    total = 0.0
    for c in range(3):
        i, j = F[f, c], F[f, (c + 1) % 3]
        total += (P[i, 0] - P[j, 0]) ** 2 + (P[i, 1] - P[j, 1]) ** 2 + (P[i, 2] - P[j, 2]) ** 2
    return np.sqrt(total / 3)


@compiled
def seed(state, f, trials, number):
    """Start the random numbers of a try: state[RANDOM]."""
    state[RANDOM] = (f * 1_000_003 + trials * 8191 + number) * MULTIPLIER + INCREMENT


@compiled
def _random(state):
    """The next random number, -1..1: a linear congruential generator modulo 2^64, of which 20 bits are used."""
    state[RANDOM] = state[RANDOM] * MULTIPLIER + INCREMENT
    return ((state[RANDOM] >> 33) & 0xFFFFF) / 524288.0 - 1.0


@compiled
def _move(surface, points, v, x, y, z, w):
    """Move point v by (x, y, z) over the surface; w (3,): work space."""
    w[0], w[1], w[2] = points.b[v, 0], points.b[v, 1], points.b[v, 2]
    g = trace_geodesic(surface, points.face[v], w, x, y, z)
    move_point(surface, points, v, g, w)


@compiled
def _perturb(surface, points, region, count, size):
    """Move the region's first vertices by up to `size` in each coordinate, at random."""
    for i in range(count):
        x = size * _random(region.state)
        y = size * _random(region.state)
        z = size * _random(region.state)
        _move(surface, points, region.vertices[i], x, y, z, region.search.tried)


@compiled
def _smooth(surface, rings, points, level, region, count):
    """Move the region's first vertices to the middles of their rings of a level, some times."""
    for _ in range(SMOOTH):
        for i in range(count):
            v = region.vertices[i]
            x, y, z = middle(rings, points.P, v, level)
            _move(surface, points, v, x - points.P[v, 0], y - points.P[v, 1], z - points.P[v, 2], region.search.tried)


@compiled
def relocate_corners(surface, rings, points, f, level, region, within, thorough, covered):
    """Relocate the free corners of face f of a level, one after the other, while it is flipped; True if one moved.

    within: only those of the region, in a trial; when they moved is noted in trial_times, else in times.
    thorough, covered: see `relocate_vertex`.
    """
    moved = region.trial_times.moved if within else region.times.moved
    time = region.state[TRIAL_TIME] if within else region.state[TIME]
    found = False
    for c in range(3):
        v = rings.F[f, c]
        if not is_flipped(rings.F, points.P, points.N, f, FLIPPED_SURFACE):
            break
        if not rings.fixed[v] and (not within or region.mark[v] == region.state[MARK]):
            region.state[WORK_LEFT] -= STEP
            if relocate_vertex(surface, rings, points, f, c, level, region.search, thorough, covered):
                moved[v] = time
                found = True
    return found


@compiled
def flipped_in(rings, points, region):
    """How many of the region's faces are flipped."""
    faces = region.faces_to[len(rings.at) - 1]
    return count_flipped(rings, points, region, 0, faces, faces)


@compiled
def _relocate_all(surface, rings, points, before, most, region, covered):
    """Relocate corners of the region's flipped faces, `before` of which were flipped before the trial; above `most` there is no
    hope.

    What failed is tried again only when something moved round it.
    """
    levels, state, times = len(rings.at), region.state, region.trial_times
    faces = region.faces_to[levels - 1]
    after = flipped_in(rings, points, region)
    thorough, begun = False, 0
    for _ in range(SWEEPS):
        if after == 0 or after > most:
            break
        if begun == 0 or thorough != (after <= before):  # what failed at less may do now
            thorough = after <= before
            state[TRIAL_TIME] += 1
            begun = state[TRIAL_TIME]
        moved, level = False, 0
        for k in range(faces):
            f = region.faces[k]
            while k >= region.faces_to[level]:
                level += 1
            if not is_flipped(rings.F, points.P, points.N, f, FLIPPED_SURFACE):
                continue
            if times.steps[f] >= begun and not changed(rings, f, times.steps[f], times.moved):
                continue
            state[TRIAL_TIME] += 1
            times.steps[f] = state[TRIAL_TIME]
            moved |= relocate_corners(surface, rings, points, f, level, region, True, thorough, covered)
        after = flipped_in(rings, points, region)
        if not moved:
            break


@compiled
def perturb_region(surface, rings, points, f, level, trial, free, region, effort, before):
    """Smooth the region's first `free` vertices (trial 0) or move them at random, and relocate corners of what is flipped then.

    The random step grows with trial / effort.trials. before: the region's Fitness. Returns whether that left fewer flipped faces
    and the rest is no worse (see `better`), how many finer vertices followed, and whether all did, without flipping too many.
    """
    most = before.flipped + max(WORSE, region.faces_to[len(rings.at) - 1] // WORSE_OF)
    if trial == 0:
        _smooth(surface, rings, points, level, region, free)
    else:
        _perturb(surface, points, region, free, _size(rings.F, points.P, f) * (LEAST + (1.0 - LEAST) * trial / effort.trials))
    followed, promising = propagate(surface, rings, points, level, region, most)
    success = False
    if promising:
        _relocate_all(surface, rings, points, before.flipped, most, region, effort.covered)
        success = better(rings, points, region, before, before.flipped - 1, FARTHER, effort.covered)
    return success, followed, promising
