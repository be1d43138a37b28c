"""Bits that are paid before anything is coded: about what values of such a distribution cost."""
import numpy as np

from npm_blender.core.fitting.rates import bits_of, class_of, default_rate, measured_rate


def test_larger_integers_cost_more_and_sign_counts_for_nothing():
    table = default_rate(2).again
    bits = [bits_of(table, x) for x in (0, 1, 2, 5, 6, 40, 1000)]
    assert bits == sorted(bits) and bits_of(table, -7) == bits_of(table, 7)


def test_what_is_measured_is_about_the_entropy():
    rng = np.random.default_rng(0)
    first, near = np.array([0, 100, 4000]), np.full((4000, 8), -1, np.int32)
    value = np.rint(rng.laplace(0, 0.7, 4000)).astype(np.int64)
    rate = measured_rate(value, np.zeros(4000, np.int64), near, first)
    paid = sum(bits_of(rate.fresh[1, 0], int(x)) for x in value[100:])
    p = np.unique(value[100:], return_counts=True)[1] / 3900
    assert abs(paid / (-3900 * (p * np.log2(p)).sum()) - 1) < 0.05


def test_rare_changes_are_dear():
    rng = np.random.default_rng(0)
    first, near = np.array([0, 4000]), np.full((4000, 8), -1, np.int32)
    old = np.full(4000, 4)
    rate = measured_rate(old + (rng.random(4000) < 0.01), old, near, first)
    assert rate.again[0] < 0.1 and rate.again[1] > 5


def test_busy_surroundings_are_a_class_of_their_own():
    value, near = np.array([0, 1, -3, 9, 0, 0, 0]), np.array([[1, -1, -1, -1, -1, -1], [1, 2, -1, -1, -1, -1],
                                                             [1, 2, 3, -1, -1, -1], [4, 5, -1, -1, -1, -1]], np.int32)
    assert [int(class_of(value, near, v)) for v in range(4)] == [1, 2, 3, 0]
