"""The tries of shakes (see `shake`) on several threads: each has a copy of the points, and makes its share of them.

The first try, by number, that succeeds is the one that counts, so the result does not depend on the number of threads.
"""
from concurrent.futures import ThreadPoolExecutor
from typing import Self

import numpy as np

from ..geometry import SurfacePoints, TraceMesh
from ..jit import compiled
from ..parallel import first_time, threads
from .one_rings import OneRings
from .perturbation import shake_all
from .trial import SMOOTHED, TrialRegion, commit, restore

MOST = 4  # threads
NONE = np.iinfo(np.int64).max


@compiled
def _copy(points, v, copy):
    """Put point v to the same place in a copy."""
    copy.face[v] = points.face[v]
    for c in range(3):
        copy.b[v, c], copy.P[v, c], copy.N[v, c] = points.b[v, c], points.P[v, c], points.N[v, c]


@compiled
def _follow(points, moved, since, copy):
    """Put the points that moved since that time to the same place in a copy."""
    for v in range(len(moved)):
        if moved[v] > since:
            _copy(points, v, copy)


@compiled
def _take(points, patch, count, copy):
    """Put the patch's vertices to the same place in a copy."""
    for i in range(count):
        _copy(points, patch.vertices[i], copy)


class ParallelTrials:
    """Shakes faces of the points on a surface; a context that ends its threads.

    patch: its times and work left are kept; most: the largest number of trials (see `shake.shake_all`).
    """

    def __init__(self, surface: TraceMesh, rings: OneRings, points: SurfacePoints, patch: TrialRegion, most: int) -> None:
        self._surface, self._rings, self._points, self._patches = surface, rings, [points], [patch]
        self._count, self._since, self._room = min(threads(), MOST), -1, most + SMOOTHED
        self._pool = ThreadPoolExecutor(max(self._count - 1, 1))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown()

    def _ready(self) -> None:
        """Give each thread its copy of the points as they are now."""
        points, patch = self._points[0], self._patches[0]
        while len(self._points) < self._count:
            self._points.append(SurfacePoints(*(array.copy() for array in points)))
            self._patches.append(patch.another())
            self._since = patch.state[3]
        if patch.state[3] > self._since:
            for copy in self._points[1:]:
                _follow(points, patch.moved, self._since, copy)
            self._since = patch.state[3]

    def shake(self, faces: np.ndarray, trials: int, covered: float) -> int:
        """Shake those of the faces (k,) int64, in rising order, that are turned, up to the first that gets better: its place
        among them, or -1. See `shake.shake_all`."""
        self._ready()
        workers, patch = 1 if first_time(shake_all.py_func) else self._count, self._patches[0]
        won, costs = np.array([NONE]), np.zeros((workers, len(faces), self._room), np.int64)
        failed = np.zeros((workers, len(faces), SMOOTHED), bool)

        def tries(own: int) -> tuple[int, int]:
            return shake_all(self._surface, self._rings, self._points[own], faces, trials, self._patches[own], covered, own,
                             workers, won, costs[own], failed[own])

        others = [self._pool.submit(tries, own) for own in range(1, workers)]
        found = [tries(0), *(other.result() for other in others)]
        best = min((number for number, _ in found if number >= 0), default=-1)
        end = best + 1 if best >= 0 else len(faces) * self._room
        # each try was made by one worker; those after the first that succeeded do not count
        patch.state[2] -= costs.sum(0).reshape(-1)[:end].sum()
        patch.state[3] += 1
        at, number = divmod(best, self._room) if best >= 0 else (-1, 0)
        done = at if best >= 0 else len(faces)
        f, width = np.nonzero(failed[:, :done].any(0))
        patch.smoothed[faces[f], width] = patch.state[3]
        if best < 0:
            return -1
        winner = number % workers
        for own, (other, count) in enumerate(found):
            if other >= 0 and own != winner:
                restore(self._points[own], self._patches[own], count)
        count = found[winner][1]
        for own in range(self._count):
            if own != winner:
                _take(self._points[winner], self._patches[winner], count, self._points[own])
        patch.vertices[:count] = self._patches[winner].vertices[:count]
        commit(patch, count)
        return at
