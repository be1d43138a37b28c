import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from npm_blender.core.mesh.components import component_labels, count_roots


@given(st.integers(1, 30), st.lists(st.tuples(st.integers(0, 29), st.integers(0, 29)), max_size=40))
def test_labels_are_the_smallest_members_of_the_parts(n, pairs):
    a, b = (np.array(pairs, np.int64).reshape(-1, 2) % n).T
    labels = component_labels(n, a, b)
    count, part = connected_components(coo_matrix((np.ones(len(a)), (a, b)), (n, n)), directed=False)
    assert len(np.unique(labels)) == count
    for k in range(count):
        assert (labels[part == k] == np.flatnonzero(part == k)[0]).all()


def test_parts_of_each_owner_are_counted():
    owner = np.array([0, 0, 0, 2, 2])  # nodes 0-1 are joined, 2 is alone; 3-4 are joined
    assert count_roots(owner, np.array([0, 4]), np.array([1, 3]), 4).tolist() == [2, 0, 1, 0]
