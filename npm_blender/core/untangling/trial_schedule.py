"""Which perturbations are tried for a flipped face, in which order, and by which of several workers.

What costs least comes first: few rings round the face before many, smoothing before random steps. Each try has its own random
seed, so the result is the same on every run.
"""
from typing import NamedTuple

import numpy as np

from ..geometry import FLIPPED_SURFACE, is_flipped
from ..jit import compiled
from .perturbation import flipped_in, perturb_region, seed
from .trial import SMOOTHED, WORK_LEFT, add, add_neighbours, begin, fitness, gather, restore, save


class Share(NamedTuple):
    """What one of several workers does: of the tries, numbered by face and then within it, number worker, worker + workers, ...

    A face k of a list has less than t tries, so its try i is number k t + i. won (1,) int64, shared by all workers: the least
    number that succeeded so far; it is not worth going on past that. costs (faces, t) int64 gets the work of each try;
    failed (faces, SMOOTHED) bool: whether smoothing with so many rings left as many flipped faces.
    """

    worker: int
    workers: int
    won: np.ndarray
    costs: np.ndarray
    failed: np.ndarray


@compiled
def _is_tried(trial, width, smooth):
    """Whether a trial is made with `width` rings round the face; smooth: whether smoothing these may succeed now.

    trial                 width 0    width 1    widths 2, 3
    0, which smooths      if smooth  if smooth  if smooth
    1 .. SMOOTHED - 1     no         no         no
    even, from there on   yes        no         no
    odd, from there on    no         yes        no
    """
    if trial == 0:
        return smooth
    return trial >= SMOOTHED and trial % 2 == width


@compiled
def _gather_round(rings, f, level, width, region):
    """The region of the free corners of face f of a level and `width` rings round them.

    Returns how many of its vertices are of that level, and how many there are in all (0: no room).
    """
    begin(region)
    count = 0
    for c in range(3):
        if not rings.fixed[rings.F[f, c]]:
            count = add(rings.F[f, c], region, count)
    for _ in range(width):
        for i in range(count):
            count = add_neighbours(rings, level, region.vertices[i], region, count)
    return count, gather(rings, level, region, count)


@compiled
def _same(rings, region, since):
    """Whether no corner of the region's faces moved since that time (0: never looked at)."""
    if since == 0:
        return False
    for i in range(region.faces_to[len(rings.at) - 1]):
        for c in range(3):
            if region.times.moved[rings.F[region.faces[i], c]] >= since:
                return False
    return True


@compiled
def _perturb_face(surface, rings, points, f, k, level, region, effort, share):
    """Make the share's tries for face f of a level, number k of the list, up to the first that succeeds (see
    `perturb_region`), with more and more rings round the face.

    Each starts from what is there now. Smoothing that left as many flipped faces is not tried again before something round it
    moved. Returns the try's number within the face that succeeded, or -1, and how many vertices of its region moved.
    """
    work, number, first = region.state[WORK_LEFT], -1, k * share.costs.shape[1]
    for width in range(SMOOTHED):
        free, count = _gather_round(rings, f, level, width, region)
        if count == 0:
            break
        smooth = not _same(rings, region, region.times.smoothing[f, width])
        if not smooth and width >= 2:
            continue
        save(points, region, count)
        before = fitness(rings, points, region)
        for trial in range(effort.trials if width < 2 else 1):
            if not _is_tried(trial, width, smooth):
                continue
            number += 1
            if number % share.workers != share.worker:
                continue
            if first + number > share.won[0]:
                return -1, 0
            seed(region.state, f, effort.trials, number + 1)
            success, followed, promising = perturb_region(surface, rings, points, f, level, trial, free, region, effort, before)
            share.costs[k, number] = free + followed + work - region.state[WORK_LEFT]
            region.state[WORK_LEFT] = work
            if success:
                share.won[0] = min(share.won[0], first + number)
                return number, count
            if trial == 0:
                share.failed[k, width] = not promising or flipped_in(rings, points, region) >= before.flipped
            restore(points, region, count)
    return -1, 0


@compiled
def perturb_faces(surface, rings, points, faces, region, effort, share):
    """Make the share's tries for those of the faces (k,) int64, in rising order, that are flipped, up to the first that succeeds.

    Returns its number, of all faces, or -1, and how many vertices of its region moved. See `_perturb_face`, Effort and Share.
    """
    room, level = share.costs.shape[1], 0
    for k in range(len(faces)):
        f = faces[k]
        if k * room > share.won[0]:
            break
        if not is_flipped(rings.F, points.P, points.N, f, FLIPPED_SURFACE):
            continue
        while f >= rings.first[level + 1]:
            level += 1
        found, count = _perturb_face(surface, rings, points, f, k, level, region, effort, share)
        if found >= 0:
            return k * room + found, count
    return -1, 0
