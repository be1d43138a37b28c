import numpy as np
import pytest

from npm_blender.core.geometry.face_orientation import FLIPPED_SURFACE, orientation_cosine, orientation_measures
from npm_blender.core.untangling.vertex_moves import score


def cosine(rings, points, f):
    return orientation_cosine(*orientation_measures(points.P, points.N, *rings.F[f])[:2])


def test_a_score_that_gives_up_early_says_so_and_else_is_the_whole_one(case):
    H, rings, points = case
    gave_up = 0
    for v in np.flatnonzero(~rings.fixed):
        count, total, height, area = score(rings, points, v, 2, np.inf, np.inf)
        faces = [f for k in range(2) for f in rings.faces[rings.at[k, v]:rings.at[k, v + 1]]]
        cosines = np.array([cosine(rings, points, f) for f in faces])
        flipped = cosines[cosines <= FLIPPED_SURFACE]
        assert count == len(flipped) and total == pytest.approx(flipped.sum(), abs=1e-9)
        assert score(rings, points, v, 2, count, height) == (count, total, height, area)
        if count:
            assert score(rings, points, v, 2, count - 1, np.inf)[0] == count
            gave_up += 1
        assert score(rings, points, v, 2, np.inf, 0.5 * height)[2] > 0.5 * height or height == 0
    assert gave_up > 3
