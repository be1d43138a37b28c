import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from npm_blender.core import features
from npm_blender.core.subdivide import hierarchy
from tests.shapes import icosphere

LEVELS = hierarchy(icosphere(0).F, 12, 2)


def test_numbers_split_into_level_and_face():
    number = np.arange(20 + 80)
    level, face = features.split(number, LEVELS[:-1])
    assert (level == (number >= 20)).all()
    assert (face == np.where(number >= 20, number - 20, number)).all()


@given(st.integers(0, 2**31))
def test_magnitude_order_is_descending_and_leaves_out_zeros(seed):
    random = np.random.default_rng(seed)
    values = random.normal(size=(50, 8)) * (random.random(50) < 0.6)[:, None]
    order = features.magnitude_order(values)
    norm = np.linalg.norm(values[order], axis=1)
    assert (np.diff(norm) <= 0).all() and (norm > 0).all()
    assert set(order) == set(np.flatnonzero(values.any(1)))


def test_gains_add_up_what_a_level_saves_over_its_face():
    random = np.random.default_rng(0)
    errors = [random.random(320) + k for k in (2.0, 1.0, 0.0)]
    gains = features.measured_gains(errors, LEVELS[:-1])
    assert gains.shape == (100,)
    assert np.isclose(gains[20:].sum(), (errors[1] - errors[2]).sum())
    own = (errors[0] - errors[1]).reshape(20, 16).sum(1)
    assert (gains[:20] >= own).all()


@given(st.integers(0, 2**31))
def test_parents_come_before_their_best_child(seed):
    random = np.random.default_rng(seed)
    gains = features.measured_gains([random.normal(size=320) for _ in range(3)], LEVELS[:-1])
    order = features.gain_order(np.ones((100, 8)), gains)
    place = np.argsort(order)
    best = 20 + np.arange(20) * 4 + gains[20:].reshape(20, 4).argmax(1)
    positive = gains[best] > 0
    assert (place[:20] < place[best])[positive].all()


@given(st.integers(0, 2**31))
def test_the_staged_order_is_the_gain_order_but_for_its_second_stage(seed):
    random = np.random.default_rng(seed)
    levels = hierarchy(icosphere(1).F, 42, 2)
    errors = [random.random(80 * 16) + k for k in (2.0, 1.0, 0.0)]
    values = random.normal(size=(80 + 320, 8)) * (random.random(400) < 0.9)[:, None]
    plain = features.gain_order(values, features.measured_gains(errors, levels[:-1]))
    staged = features.staged_order(values, errors, levels[:-1])
    first, second = features.STAGES[:2]
    assert np.array_equal(staged[:first], plain[:first]) and np.array_equal(staged[second:], plain[second:])
    assert set(staged) == set(plain) and len(staged) == len(plain)
    # a region stays together: all features of a base face come in one run, parents first as before
    level, face = features.split(staged[first:second], levels[:-1])
    base = face // 4 ** level.astype(int)
    assert (np.diff(base) != 0).sum() == len(np.unique(base)) - 1


def test_the_region_that_gains_most_comes_first():
    levels = hierarchy(icosphere(2).F, 162, 1)
    far = np.arange(320) >= 160
    errors = [np.repeat(np.where(far, 3.0, 1.0), 4), np.repeat(np.where(far, 1.0, 0.5), 4)]
    order = features.staged_order(np.ones((320, 8)), errors, levels[:-1])
    rest = order[features.STAGES[0]:]
    assert far[rest[:60]].all() and not far[rest[-60:]].any()
