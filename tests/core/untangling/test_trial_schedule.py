"""Which tries there are: by width of the region and number of the trial."""
import numpy as np
import pytest

from npm_blender.core.geometry import FLIPPED_SURFACE, is_flipped
from npm_blender.core.untangling.perturbation import Effort
from npm_blender.core.untangling.trial import SMOOTHED
from npm_blender.core.untangling.trial_schedule import Share, _is_tried, perturb_faces

from .test_perturbation import folded
from .test_trial import Flat

NONE = np.iinfo(np.int64).max


def tried(width, smooth, trials=12):
    return [trial for trial in range(trials) if _is_tried(trial, width, smooth)]


def test_random_trials_are_shared_between_two_widths_and_wide_regions_are_smoothed_only():
    assert tried(0, True) == [0, 4, 6, 8, 10] and tried(1, True) == [0, 5, 7, 9, 11]
    assert [tried(width, True) for width in (2, 3)] == [[0], [0]]
    assert [tried(width, False) for width in range(SMOOTHED)] == [[4, 6, 8, 10], [5, 7, 9, 11], [], []]


@pytest.mark.parametrize("trials", [1, 4, 5, 16, 128])
def test_no_face_has_more_tries_than_there_is_room_for(trials):
    widths = sum(len(tried(width, True, trials if width < 2 else 1)) for width in range(SMOOTHED))
    assert widths == max(trials - SMOOTHED, 0) + SMOOTHED < trials + SMOOTHED + 1


def test_workers_share_the_tries_and_each_costs_the_same_whoever_makes_it():
    trials, costs = 16, {}
    for workers in (1, 3):
        total = np.zeros((1, trials + SMOOTHED), np.int64)
        for worker in range(workers):
            flat = Flat()
            flat.region.set_work(10**6)
            f = folded(flat)
            share = Share(worker, workers, np.array([NONE]), np.zeros_like(total), np.zeros((1, SMOOTHED), bool))
            found, count = perturb_faces(flat.surface, flat.rings, flat.points, np.array([f]), flat.region,
                                         Effort(trials, 1e9), share)  # no try keeps so much of the area
            assert (found, count) == (-1, 0) and is_flipped(flat.rings.F, flat.points.P, flat.points.N, f, FLIPPED_SURFACE)
            made = np.flatnonzero(share.costs[0])
            assert (made % workers == worker).all() and len(made) > 0 and flat.region.work_left == 10**6
            total += share.costs
        costs[workers] = total
    assert np.array_equal(costs[1], costs[3])


def test_nobody_goes_on_past_a_try_that_succeeded():
    flat = Flat()
    flat.region.set_work(10**6)
    f = folded(flat)
    share = Share(0, 1, np.array([1]), np.zeros((1, 20), np.int64), np.zeros((1, SMOOTHED), bool))
    perturb_faces(flat.surface, flat.rings, flat.points, np.array([f]), flat.region, Effort(16, 1e9), share)
    assert np.flatnonzero(share.costs[0]).tolist() == [0, 1]
