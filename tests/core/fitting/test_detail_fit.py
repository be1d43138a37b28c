"""Integers: each stage is nearer than the one before, a dearer bit makes fewer of them, none moves farther than it may."""
import numpy as np
import pytest

from npm_blender.core.bitstream import encode_displacements
from npm_blender.core.fitting import StageFit, default_rate
from npm_blender.core.fitting.detail_fit import REACH, TRADE
from tests.core.fitting.samples import SHAPES, detail_fit, none

LEVELS = 2
STEPS = 0.02 * 1.4 ** np.arange(LEVELS + 1)


def moves(fit, value, steps):
    return value * np.repeat(steps, np.diff(fit.surface.first))


@pytest.mark.parametrize("smooth", [0, 8])
@pytest.mark.parametrize("name", SHAPES)
def test_every_stage_is_nearer(name, smooth):
    fit, V0 = detail_fit(name, LEVELS, smooth)
    found, errors = None, [fit.error(V0, none(fit), 6_000)]
    for stage in range(3):
        found = fit.stage(V0, STEPS / 2**stage, found, LEVELS)
        errors.append(fit.error(V0, moves(fit, found.value, STEPS / 2**stage), 6_000))
    assert errors == sorted(errors, reverse=True) and errors[-1] < 0.4 * errors[0]
    assert found.value.dtype == np.int64 and len(found.value) == fit.surface.first[-1]


def test_a_dearer_bit_makes_fewer_bytes():
    fit, V0 = detail_fit("closed", LEVELS)
    sizes = []
    for trade in (0.02, TRADE, 1.0, 100.0):
        found = fit.stage(V0, STEPS / 4, None, LEVELS, trade=trade)
        sizes.append(len(encode_displacements(found.value[None], fit.near, fit.surface.first)[0]))
    assert sizes == sorted(sizes, reverse=True) and sizes[-1] < 0.5 * sizes[0]


def test_no_level_beyond_those_allowed_has_numbers():
    fit, V0 = detail_fit("closed", LEVELS)
    value = fit.stage(V0, STEPS, None, 1).value
    assert not value[fit.surface.new_at(2)].any() and value.any()


def test_none_moves_farther_in_a_pass_than_the_model_holds():
    fit, V0 = detail_fit("closed", LEVELS)
    V0 = 1.6 * V0
    steps = STEPS / 16
    found = fit.stage(V0, steps, None, LEVELS, passes=1)
    at = fit.surface.build(V0, none(fit))
    for level in (1, 2):
        edges = fit.surface.hierarchy[level - 1].edges
        length = np.linalg.norm(np.diff(at.X[level - 1][edges], axis=1)[:, 0], axis=1)
        moved = np.abs(found.value[fit.surface.new_at(level)]) * steps[level]
        assert (moved <= np.maximum(REACH * length, steps[level]) + steps[level]).all()


def test_a_pass_that_does_harm_is_taken_back():
    fit, V0 = detail_fit("closed", LEVELS)
    good = fit.stage(V0, STEPS, None, LEVELS, passes=4)
    start = StageFit(good.value, default_rate(LEVELS), np.inf)
    again = fit.improved(V0, STEPS, start, np.zeros_like(good.value), LEVELS, passes=4)
    before, after = (fit.error(V0, moves(fit, v, STEPS), 6_000) for v in (good.value, again.value))
    assert after <= 1.05 * before


def test_the_same_input_gives_the_same_integers():
    (one, V0), (two, _) = detail_fit("open", LEVELS), detail_fit("open", LEVELS)
    assert np.array_equal(one.stage(V0, STEPS, None, LEVELS).value, two.stage(V0, STEPS, None, LEVELS).value)
