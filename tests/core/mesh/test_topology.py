import numpy as np
import pytest

from npm_blender.core.errors import MeshError
from npm_blender.core.mesh.topology import (
    directed_edges,
    next_halfedges,
    opposite_halfedges,
    prev_halfedges,
    topology_of,
    vertex_fans,
)
from tests.meshes.shapes import grid, icosphere, torus

SHAPES = {"sphere": icosphere(1), "torus": torus(8, 6), "open": grid(4)}


@pytest.mark.parametrize("dtype", [np.int32, np.int64])
def test_next_and_prev_go_round_the_face(dtype):
    h = np.arange(12, dtype=dtype)
    assert np.array_equal(next_halfedges(next_halfedges(h)), prev_halfedges(h))
    assert np.array_equal(prev_halfedges(next_halfedges(h)), h)
    assert np.array_equal(next_halfedges(h) // 3, h // 3)
    assert next_halfedges(h).dtype == prev_halfedges(h).dtype == dtype
    assert next_halfedges(h.reshape(4, 3))[:, 2].tolist() == [0, 3, 6, 9]


@pytest.mark.parametrize("name", SHAPES)
def test_a_half_edge_ends_where_the_next_one_starts(name):
    F = SHAPES[name].F
    start, end = directed_edges(F).T
    assert np.array_equal(start, F.reshape(-1)) and np.array_equal(end, start[next_halfedges(np.arange(F.size))])


@pytest.mark.parametrize("name", SHAPES)
def test_opposites_are_involutions_that_run_the_other_way(name):
    F = SHAPES[name].F
    h, opposite = np.arange(F.size), opposite_halfedges(F)
    assert np.array_equal(opposite[opposite], h)
    inner = opposite != h
    assert np.array_equal(directed_edges(F)[opposite][inner], directed_edges(F)[inner][:, ::-1])


def test_two_faces_the_same_way_round_an_edge_are_refused():
    with pytest.raises(MeshError, match="used twice in one direction"):
        opposite_halfedges(np.array([[0, 1, 2], [0, 1, 3]]))


def test_pinched_vertex_has_two_fans():
    F = np.array([[0, 1, 2], [0, 3, 4]])
    assert vertex_fans(F, opposite_halfedges(F), 6).tolist() == [2, 1, 1, 1, 1, 0]


def test_genus_and_borders():
    assert topology_of(torus(8, 6).F).genus == 1
    assert topology_of(icosphere(1).F).genus == 0
    sheet = topology_of(grid(3).F)
    assert (sheet.border_loops, sheet.border_edges, sheet.genus) == (1, 12, 0)
