import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from npm_blender.core.codec import importance
from npm_blender.core.mesh.subdivision import hierarchy
from tests.meshes.shapes import icosphere

LEVELS = hierarchy(icosphere(0).F, 12, 2)


def test_numbers_split_into_level_and_face():
    number = np.arange(20 + 80)
    level, face = importance.split_numbers(number, LEVELS[:-1])
    assert (level == (number >= 20)).all()
    assert (face == np.where(number >= 20, number - 20, number)).all()


@given(st.integers(0, 2**31))
def test_magnitude_order_is_descending_and_leaves_out_zeros(seed):
    random = np.random.default_rng(seed)
    values = random.normal(size=(50, 8)) * (random.random(50) < 0.6)[:, None]
    order = importance.magnitude_order(values)
    norm = np.linalg.norm(values[order], axis=1)
    assert (np.diff(norm) <= 0).all() and (norm > 0).all()
    assert set(order) == set(np.flatnonzero(values.any(1)))


def test_gains_add_up_what_a_level_saves_over_its_face():
    random = np.random.default_rng(0)
    errors = [random.random(320) + k for k in (2.0, 1.0, 0.0)]
    gains = importance.measured_gains(errors, LEVELS[:-1])
    assert gains.shape == (100,)
    assert np.isclose(gains[20:].sum(), (errors[1] - errors[2]).sum())
    own = (errors[0] - errors[1]).reshape(20, 16).sum(1)
    assert (gains[:20] >= own).all()


@given(st.integers(0, 2**31))
def test_parents_come_before_their_best_child(seed):
    random = np.random.default_rng(seed)
    gains = importance.measured_gains([random.normal(size=320) for _ in range(3)], LEVELS[:-1])
    order = importance.gain_order(np.ones((100, 8)), gains)
    place = np.argsort(order)
    best = 20 + np.arange(20) * 4 + gains[20:].reshape(20, 4).argmax(1)
    positive = gains[best] > 0
    assert (place[:20] < place[best])[positive].all()
