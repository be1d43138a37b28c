import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from npm_blender.core.geometry.disjoint_sets import find_root, unite


@pytest.mark.parametrize("seed", range(5))
def test_the_sets_are_the_components_and_the_root_is_the_smallest_member(seed):
    random = np.random.default_rng(seed)
    i, j = random.integers(0, 200, (2, 120))
    parent = np.arange(200, dtype=np.int32)
    for a, b in zip(i, j, strict=True):
        unite(parent, a, b)
    label = connected_components(coo_matrix((np.ones(120), (i, j)), (200, 200)), directed=False)[1]
    smallest = np.array([np.flatnonzero(label == k)[0] for k in label])
    assert np.array_equal([find_root(parent, k) for k in range(200)], smallest)
    assert (parent <= np.arange(200)).all()


def test_looking_for_a_root_halves_the_path_and_changes_no_set():
    parent = np.maximum(np.arange(9, dtype=np.int32) - 1, 0)  # a chain
    assert find_root(parent, 8) == 0
    assert parent.tolist() == [0, 0, 0, 2, 2, 4, 4, 6, 6]
    assert all(find_root(parent, k) == 0 for k in range(9))
