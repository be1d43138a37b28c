import numpy as np
import pytest

from npm_blender.core.errors import MeshError
from npm_blender.core.mesh.subdivision import Level, hierarchy, midpoints
from npm_blender.core.mesh.topology import directed_edges, opposite_halfedges, topology_of, vertex_fans
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
