import numpy as np
import pytest

from npm_blender.core.mesh.subdivision import ChildHalfedges, Level, hierarchy, midpoints, subdivided_opposite
from npm_blender.core.mesh.topology import directed_edges, topology_of
from tests.meshes.shapes import grid, icosphere, torus

SHAPES = {"sphere": icosphere(1), "torus": torus(8, 6), "open": grid(4)}


@pytest.mark.parametrize("name", SHAPES)
def test_subdivision_keeps_topology_and_quadruples_faces(name):
    mesh = SHAPES[name]
    levels = hierarchy(mesh.F, len(mesh.V), 2)
    first = topology_of(mesh.F)
    for i, level in enumerate(levels):
        now = topology_of(level.F)
        assert len(level.F) == len(mesh.F) * 4**i
        assert (now.euler, now.border_loops, now.components) == (first.euler, first.border_loops, first.components)
        assert now.vertices == level.n


@pytest.mark.parametrize("name", SHAPES)
def test_children_lie_in_their_parents(name):
    mesh = SHAPES[name]
    level = Level.of(mesh.F, len(mesh.V))
    V = midpoints(mesh.V, level)
    children = level.subdivided().F.reshape(-1, 4, 3)
    assert (children[:, :3, 0] == mesh.F).all()
    for k in range(3):
        a, b = mesh.V[mesh.F[:, k]], mesh.V[mesh.F[:, (k + 1) % 3]]
        assert np.allclose(V[children[:, 3, k]], (a + b) / 2)
        assert (children[:, 3, k] == children[:, k, 1]).all()
    areas = np.linalg.norm(np.cross(*(V[children[..., i]] - V[children[..., 0]] for i in (1, 2))), axis=2)
    assert np.allclose(areas.sum(1) / 2, mesh.face_areas())


@pytest.mark.parametrize("name", SHAPES)
def test_halfedges_of_an_edge_run_against_each_other(name):
    level = Level.of(SHAPES[name].F, len(SHAPES[name].V))
    d = directed_edges(level.F)
    left, right = level.edge_halfedge.T
    inner = left != right
    assert (d[left[inner]] == level.edges[inner]).all()
    assert (d[right[inner]] == level.edges[inner][:, ::-1]).all()
    assert (level.opposite[level.opposite] == np.arange(len(d))).all()
    assert (level.edge_of[left] == np.arange(len(left))).all()


@pytest.mark.parametrize("name", SHAPES)
def test_the_finer_level_is_what_a_search_for_its_edges_finds(name):
    level = Level.of(SHAPES[name].F, len(SHAPES[name].V)).subdivided()
    searched = Level.of(level.F, level.n)
    for field in ("F", "opposite", "edges", "edge_of", "edge_halfedge"):
        found = getattr(level, field)
        assert found.dtype == np.int32 and np.array_equal(found, getattr(searched, field)), field


@pytest.mark.parametrize("name", SHAPES)
def test_opposites_of_children_follow_from_those_of_the_parents_alone(name):
    level = Level.of(SHAPES[name].F, len(SHAPES[name].V))
    found = subdivided_opposite(level.opposite)
    assert found.dtype == np.int64 and np.array_equal(found, level.subdivided().opposite)


def test_every_child_half_edge_belongs_to_one_half_edge_of_the_parents():
    assert np.array_equal(np.sort(np.concatenate(ChildHalfedges.of(np.arange(15)))), np.arange(60))
