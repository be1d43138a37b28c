import numpy as np
import pytest

from npm_blender.core.untangling.propagation import NEAR, propagate, to_midpoint
from npm_blender.core.untangling.trial import count_flipped, restore

from .test_trial import Flat


def test_finer_vertices_follow_to_the_middles_of_their_edges():
    flat = Flat()
    count = flat.propagated()
    base_faces = (flat.H[0].F == flat.v).any(1)
    inside = np.setdiff1d(np.unique(flat.H[-1].F.reshape(len(flat.H[0].F), -1)[base_faces]),
                          np.unique(flat.H[-1].F.reshape(len(flat.H[0].F), -1)[~base_faces]))
    assert set(flat.region.vertices[:count]) == set(inside) - set(np.flatnonzero(flat.rings.fixed))
    first = flat.H[0]
    for e, (i, j) in enumerate(first.edges):  # the vertices of level 1 come after those of the base, in the order of its edges
        if flat.v in (i, j):
            middle = (flat.points.P[i] + flat.points.P[j]) / 2
            assert np.abs(flat.points.P[first.n + e] - middle).max() < 1e-9


def test_propagation_stops_where_a_level_has_more_flipped_faces_than_may_be():
    flat = Flat()
    count = flat.propagated()
    restore(flat.points, flat.region, count)
    flat.points.P[flat.v, :2] += 0.5  # out of its ring
    folded = count_flipped(flat.rings, flat.points, flat.region, 0, flat.region.faces_to[-1], 1000)
    finest = count_flipped(flat.rings, flat.points, flat.region, *flat.region.faces_to[-2:], 1000)
    assert 1 < finest < folded
    assert count_flipped(flat.rings, flat.points, flat.region, 0, flat.region.faces_to[-1], 0) == 1
    done, whole = propagate(flat.surface, flat.rings, flat.points, -1, flat.region, 0)
    assert not whole and done == flat.region.vertices_to[0] - 1


@pytest.mark.parametrize("start", range(3))
def test_a_vertex_comes_near_the_middle_of_its_edge_from_wherever_it_is(start):
    flat = Flat()
    first = flat.H[0]
    e = int(np.flatnonzero((first.edges == flat.v).any(1))[0])
    i, j = first.edges[e]
    v = first.n + e
    flat.points.face[v], flat.points.b[v], flat.points.P[v], flat.points.N[v] = (
        x[(i, j, flat.v)[start]] for x in (flat.points.face, flat.points.b, flat.points.P, flat.points.N))
    to_midpoint(flat.surface, flat.points, v, i, j, np.empty(3), np.empty(3))
    gap = np.linalg.norm(flat.points.P[v] - (flat.points.P[i] + flat.points.P[j]) / 2)
    assert gap <= NEAR * np.linalg.norm(flat.points.P[i] - flat.points.P[j])
