import numpy as np

from npm_blender.core.cleaning.edge_groups import EdgeGroups
from npm_blender.core.mesh import directed_edges
from tests.meshes.dirty_meshes import (
    joined,
    mesh,
    plane,
    sphere,
)


def groups(m):
    return EdgeGroups.of(m.F, len(m.V))


def test_half_edges_of_an_edge_stand_together_in_the_order_of_their_vertices():
    m = joined(sphere(1), plane(3))
    found = groups(m)
    ends = np.sort(directed_edges(m.F)[found.halfedges], 1)
    pairs, counts = np.unique(ends, axis=0, return_counts=True)
    assert np.array_equal(ends, np.repeat(pairs, counts, 0)) and np.array_equal(found.sizes, counts)
    assert np.array_equal(np.sort(found.halfedges), np.arange(m.F.size))
    assert len(found.border) == (counts == 1).sum() and not found.disagree().any()


def test_edges_along_which_two_faces_disagree():
    m = mesh(np.eye(4, 3), [[0, 1, 2], [0, 1, 3]])
    found = groups(m)
    assert found.disagree().tolist() == (found.sizes == 2).tolist() and found.disagree().sum() == 1


def test_groups_are_made_again_for_other_faces_only():
    m = sphere(1)
    found = groups(m)
    assert found.replaced(m.F) is found
    fewer = found.replaced(m.F[:-1])
    assert len(fewer.border) == 3 and fewer.n == len(m.V)
