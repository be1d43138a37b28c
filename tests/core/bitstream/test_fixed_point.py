import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import t as student

from npm_blender.core.bitstream.fixed_point import ONE_TAIL, exp2, log2, log_length, square_root, tail


@given(st.integers(1, 2**63 - 1))
def test_logarithm_is_rounded_down_to_a_step(x):
    assert math.log2(x) - 0.012 <= log2(x) / 256 <= math.log2(x) + 1e-9


@given(st.integers(-4000, 7000))
def test_power_is_near(l):
    assert abs(exp2(l) - 2.0 ** (16 + l / 256)) <= 1 + 1e-5 * 2.0 ** (16 + l / 256)


@given(st.integers(0, 2**62 - 1))
def test_root_is_exact(x):
    assert square_root(x) == math.isqrt(x)


@given(*[st.integers(-(2**59), 2**59)] * 3)
def test_length_is_near(x, y, z):
    if x or y or z:
        assert abs(log_length(x, y, z) / 256 - 0.5 * math.log2(x * x + y * y + z * z)) < 0.025


@pytest.mark.parametrize("z", np.linspace(0, 60, 40))
def test_tail_is_that_of_students_distribution(z):
    assert tail(int(z * 8192)) / ONE_TAIL == pytest.approx(student.sf(int(z * 8192) / 8192, 4), rel=2e-3, abs=2e-9)


def test_tail_never_rises():
    found = [tail(z) for z in range(0, 70 << 13, 101)]
    assert all(a >= b for a, b in zip(found, found[1:], strict=False))
