import numpy as np
import pytest

from npm_blender.core.geometry.geodesic_trace import TraceMesh, evaluate_point, move_point, points_on, trace_geodesic
from npm_blender.core.geometry.normals import vertex_normals
from npm_blender.core.mesh.topology import opposite_halfedges
from npm_blender.core.mesh.triangle_mesh import TriMesh
from tests.meshes.lod_meshes import sheet, sphere, tube


def surface_of(mesh):
    return TraceMesh(mesh.V, mesh.F, opposite_halfedges(mesh.F), vertex_normals(mesh))


def point(mesh, f, b):
    return b @ mesh.V[mesh.F[f]]


def test_a_trace_on_a_flat_sheet_is_a_straight_line():
    mesh = sheet(flat=True)
    surface = surface_of(mesh)
    rng = np.random.default_rng(0)
    for _ in range(200):
        f, b = rng.integers(len(mesh.F)), rng.dirichlet(np.ones(3))
        start = point(mesh, f, b)
        target = np.append(rng.uniform(-0.3, 0.3, 2), 0.0)
        g = trace_geodesic(surface, f, b, *(target - start))
        assert np.abs(point(mesh, g, b) - target).max() < 1e-9


def test_a_trace_stops_at_the_border():
    mesh = sheet(flat=True)
    b = np.full(3, 1 / 3)
    f = len(mesh.F) // 2
    start = point(mesh, f, b)
    g = trace_geodesic(surface_of(mesh), f, b, 10.0, 0.0, 0.0)
    assert point(mesh, g, b) == pytest.approx([mesh.V[:, 0].max(), start[1], 0])


def test_a_trace_round_a_tube_keeps_its_length_and_comes_back():
    mesh = tube(rows=40, columns=60)
    f, b = len(mesh.F) // 2, np.full(3, 1 / 3)
    start = point(mesh, f, b)
    edge = np.linalg.norm(mesh.V[0] - mesh.V[1])
    direction = np.array([-start[1], start[0], 0]) / np.hypot(*start[:2])
    normal = mesh.face_normals()[f]
    direction -= normal * (direction @ normal)
    g = trace_geodesic(surface_of(mesh), f, b, *(60 * edge * direction / np.linalg.norm(direction)))
    assert np.linalg.norm(point(mesh, g, b) - start) < 0.1 * edge


@pytest.mark.parametrize("apex", [[0.5, 0.0, 0.0], [0.0, 0.0, 0.0]], ids=["no area", "an edge without length"])
def test_a_trace_stops_at_a_face_without_area(apex):
    V = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1, 0], apex, [0.5, -1, 0]], float)
    mesh = TriMesh(V, np.array([[0, 1, 2], [1, 0, 3], [0, 4, 3], [4, 1, 3]], np.int32))
    b = np.full(3, 1 / 3)
    assert trace_geodesic(surface_of(mesh), 0, b, 0.0, -1.0, 0.0) == 1
    assert point(mesh, 1, b) == pytest.approx([0.5, 0, 0]) and b.min() >= 0 and b.sum() == pytest.approx(1)
    before = b.copy()
    assert trace_geodesic(surface_of(mesh), 1, b, 0.1, 0.0, 0.0) == 1 and np.array_equal(b, before)


def test_points_have_places_and_normals_of_length_one_or_none():
    mesh = sphere(3)
    rng = np.random.default_rng(0)
    face, b = rng.integers(0, len(mesh.F), 50).astype(np.int32), rng.dirichlet(np.ones(3), 50)
    N = vertex_normals(mesh)
    surface = TraceMesh(mesh.V, mesh.F, opposite_halfedges(mesh.F), N)
    points = points_on(surface, face, b)
    assert np.allclose(points.P, np.einsum("nk,nkd->nd", b, mesh.V[mesh.F[face]]))
    assert np.allclose(np.linalg.norm(points.N, axis=1), 1) and ((points.N * points.P).sum(1) > 0.4).all()
    points.b[:] = 0  # copies
    assert b.any()
    N[mesh.F[0]] = [[0, 0, 1], [0, 0, -1], [0, 0, 0]]
    cancelled = points_on(surface, np.zeros(1, np.int32), np.array([[0.5, 0.5, 0.0]]))
    assert not cancelled.N.any()


def test_a_point_is_evaluated_without_moving_and_moves_with_its_place_and_normal():
    mesh = sphere(3)
    surface = surface_of(mesh)
    points = points_on(surface, np.zeros(2, np.int32), np.full((2, 3), 1 / 3))
    before, b = [x.copy() for x in points], np.array([0.2, 0.3, 0.5])
    evaluate_point(surface, points, 1, 7, b)
    assert np.array_equal(points.face, before[0]) and np.array_equal(points.b, before[1])
    assert np.allclose(points.P[1], point(mesh, 7, b)) and np.linalg.norm(points.N[1]) == pytest.approx(1)
    there = points.P[1].copy()
    move_point(surface, points, 1, 7, b)
    assert points.face.tolist() == [0, 7] and np.array_equal(points.b[1], b) and np.array_equal(points.P[1], there)
    assert all(np.array_equal(now[0], then[0]) for now, then in zip(points, before, strict=True))
