import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from npm_blender.core.mesh.radix_order import radix_argsort


@given(st.lists(st.integers(0, 20) | st.integers(0, 2**62), max_size=40))
def test_sorts_and_keeps_equal_keys_in_their_order(keys):
    keys = np.array(keys, np.int64)
    assert np.array_equal(radix_argsort(keys), np.argsort(keys, kind="stable"))


def test_keys_that_leave_no_room_for_the_index_are_sorted_too():
    keys = np.array([2**63 - 1, 0, 2**63 - 1, 5])
    assert radix_argsort(keys).tolist() == [1, 3, 0, 2]


def test_small_integer_types_do_not_overflow():
    assert radix_argsort(np.array([120, 3, 120, 7], np.int8)).tolist() == [1, 3, 0, 2]
