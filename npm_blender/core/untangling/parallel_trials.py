"""The tries of perturbations (see `trial_schedule`) on several threads: each has a copy of the points, and makes its share.

The first try, by number, that succeeds is the one that counts, so the result does not depend on the number of threads.
"""
from concurrent.futures import ThreadPoolExecutor
from typing import Self

import numpy as np

from ..geometry import SurfacePoints, TraceMesh
from ..jit import compiled
from ..parallel import first_time, threads
from .one_rings import OneRings
from .perturbation import Effort
from .trial import SMOOTHED, TIME, TrialRegion, commit, restore
from .trial_schedule import Share, perturb_faces

MOST = 4  # threads
NONE = np.iinfo(np.int64).max  # no try succeeded yet


@compiled
def _copy(points, v, copy):
    """Put point v to the same place in a copy."""
    copy.face[v] = points.face[v]
    for c in range(3):
        copy.b[v, c], copy.P[v, c], copy.N[v, c] = points.b[v, c], points.P[v, c], points.N[v, c]


@compiled
def _copy_moved(points, moved, since, copy):
    """Put the points that moved since that time to the same place in a copy."""
    for v in range(len(moved)):
        if moved[v] > since:
            _copy(points, v, copy)


@compiled
def _copy_region(points, region, count, copy):
    """Put the region's first `count` vertices to the same place in a copy."""
    for i in range(count):
        _copy(points, region.vertices[i], copy)


class ParallelTrials:
    """Perturbs flipped faces of the points on a surface; a context that ends its threads.

    region: its times and work left are kept; most: the largest number of trials (see `perturbation.Effort`).
    """

    def __init__(self, surface: TraceMesh, rings: OneRings, points: SurfacePoints, region: TrialRegion, most: int) -> None:
        self._surface, self._rings, self._points, self._regions = surface, rings, [points], [region]
        self._count, self._since, self._room = min(threads(), MOST), -1, most + SMOOTHED
        self._pool = ThreadPoolExecutor(max(self._count - 1, 1))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown()

    def _update_copies(self) -> None:
        """Give each thread its copy of the points as they are now."""
        points, region = self._points[0], self._regions[0]
        while len(self._points) < self._count:
            self._points.append(SurfacePoints(*(array.copy() for array in points)))
            self._regions.append(region.another())
            self._since = region.time
        if region.time > self._since:
            for copy in self._points[1:]:
                _copy_moved(points, region.times.moved, self._since, copy)
            self._since = region.time

    def _run(self, faces: np.ndarray, effort: Effort) -> tuple[list[tuple[int, int]], np.ndarray, np.ndarray]:
        """What each worker found (see `perturb_faces`), the work of each try (faces, t), and what smoothing failed."""
        workers = 1 if first_time(perturb_faces) else self._count
        won, costs = np.array([NONE]), np.zeros((workers, len(faces), self._room), np.int64)
        failed = np.zeros((workers, len(faces), SMOOTHED), bool)

        def tries(worker: int) -> tuple[int, int]:
            return perturb_faces(self._surface, self._rings, self._points[worker], faces, self._regions[worker], effort,
                                 Share(worker, workers, won, costs[worker], failed[worker]))

        others = [self._pool.submit(tries, worker) for worker in range(1, workers)]
        found = [tries(0), *(other.result() for other in others)]
        return found, costs.sum(0), failed.any(0)  # each try was made by one worker

    def _keep(self, found: list[tuple[int, int]], winner: int) -> None:
        """Undo what succeeded elsewhere, and give all threads what the winner moved."""
        for worker, (number, count) in enumerate(found):
            if number >= 0 and worker != winner:
                restore(self._points[worker], self._regions[worker], count)
        count, region = found[winner][1], self._regions[0]
        for worker in range(self._count):
            if worker != winner:
                _copy_region(self._points[winner], self._regions[winner], count, self._points[worker])
        region.vertices[:count] = self._regions[winner].vertices[:count]
        commit(region, count)

    def try_perturbations(self, faces: np.ndarray, trials: int, covered: float) -> int:
        """Perturb those of the faces (k,) int64, in rising order, that are flipped, up to the first that gets better: its place
        among them, or -1. trials, covered: see `perturbation.Effort`."""
        self._update_copies()
        found, costs, failed = self._run(faces, Effort(trials, covered))
        region = self._regions[0]
        best = min((number for number, _ in found if number >= 0), default=-1)
        end = best + 1 if best >= 0 else costs.size
        region.set_work(region.work_left - int(costs.reshape(-1)[:end].sum()))  # tries after the first success do not count
        region.state[TIME] += 1
        place, number = divmod(best, self._room) if best >= 0 else (-1, 0)
        f, width = np.nonzero(failed[:place if best >= 0 else len(faces)])
        region.times.smoothing[faces[f], width] = region.time
        if best >= 0:
            self._keep(found, number % len(found))
        return place
