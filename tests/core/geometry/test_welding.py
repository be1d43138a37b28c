import numpy as np
import pytest

from npm_blender.core.geometry.welding import weld


@pytest.mark.parametrize("seed", range(3))
def test_rows_are_welded_where_they_are_the_same_bit_by_bit(seed):
    random = np.random.default_rng(seed)
    V = random.integers(-2, 3, (300, 3)) * random.choice([0.1, 1.0, 1e300], (300, 1))
    first, place = weld(V)
    assert np.array_equal(V[first][place], V) and (np.diff(first) > 0).all()
    assert len(first) == len(np.unique(V + 0.0, axis=0))
    assert all((V[:i] != V[i]).any(1).all() for i in first)


def test_neighbouring_floats_stay_apart_and_both_zeros_are_one_place():
    V = np.array([[0.0, 1, 1], [-0.0, 1, 1], [0, np.nextafter(1, 2), 1]])
    assert [x.tolist() for x in weld(V)] == [[0, 2], [0, 0, 1]]


def test_nothing_is_welded_to_nothing():
    assert [len(x) for x in weld(np.zeros((0, 3)))] == [0, 0]
