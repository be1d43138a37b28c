import igl
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.errors import MeshError
from npm_blender.core.geometry.closest_point import ClosestPoints
from npm_blender.core.geometry.sampling import sample
from npm_blender.core.mesh.triangle_mesh import TriMesh


def torus(n=40, m=20):
    u, v = np.meshgrid(np.arange(n) * 2 * np.pi / n, np.arange(m) * 2 * np.pi / m, indexing="ij")
    r = 0.3 + 0.1 * np.cos(v)
    V = np.stack([r * np.cos(u), r * np.sin(u), 0.1 * np.sin(v)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    a, b = i * m + j, (i + 1) % n * m + j
    c, d = (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m
    return TriMesh(V, np.stack([a, b, c, a, c, d], -1).reshape(-1, 3).astype(np.int32))


def soup(seed, faces):
    random = np.random.default_rng(seed)
    centre = random.normal(size=(faces, 1, 3))
    corners = centre + random.normal(size=(faces, 3, 3)) * random.choice([1e-4, 0.1, 2.0], (faces, 1, 1))
    return TriMesh(corners.reshape(-1, 3), np.arange(3 * faces, dtype=np.int32).reshape(-1, 3))


def brute_force(P, mesh):
    return igl.point_mesh_squared_distance(P, mesh.V, mesh.F.astype(np.int64))


@given(st.integers(0, 2**31), st.integers(1, 400))
@settings(max_examples=40, deadline=None)
def test_closest_agrees_with_libigl_on_random_triangles(seed, faces):
    mesh = soup(seed, faces)
    P = np.random.default_rng(seed + 1).normal(size=(200, 3)) * 2
    distance, point, face = ClosestPoints(mesh).closest(P)
    expected, _, there = brute_force(P, mesh)[:3]
    np.testing.assert_allclose(distance, np.sqrt(expected), atol=1e-9)
    np.testing.assert_allclose(point, there, atol=1e-6)
    # the face that is named holds the point
    np.testing.assert_allclose([ClosestPoints(TriMesh(mesh.V, mesh.F[[f]])).closest(p[None])[0][0]
                                for f, p in zip(face[:20], point[:20], strict=True)], 0, atol=1e-9)


def test_closest_agrees_with_libigl_on_a_surface():
    mesh = torus()
    P = sample(mesh, 20_000, 3)[0] + np.random.default_rng(0).normal(scale=0.02, size=(20_000, 3))
    distance, point, _ = ClosestPoints(mesh).closest(P)
    expected, _, there = brute_force(P, mesh)[:3]
    np.testing.assert_allclose(distance, np.sqrt(expected), atol=1e-12)
    np.testing.assert_allclose(point, there, atol=1e-6)


DEGENERATE = {
    "point": [[1, 1, 1], [1, 1, 1], [1, 1, 1]],
    "segment, repeated corner": [[0, 0, 0], [0, 0, 0], [1, 1, 1]],
    "segment, corner between": [[0, 0, 0], [0.5, 0.5, 0.5], [1, 1, 1]],
    "segment, corner first": [[0.5, 0.5, 0.5], [1, 1, 1], [0, 0, 0]],
}


@pytest.mark.parametrize("name", DEGENERATE)
def test_faces_without_area_count_as_points_and_segments(name):
    V = np.array(DEGENERATE[name], float)
    P = np.random.default_rng(0).normal(size=(50, 3))
    t = np.linspace(0, 1, 10_001)[:, None]
    ends = V[[V.sum(1).argmin(), V.sum(1).argmax()]]
    expected = np.linalg.norm(P[:, None] - (ends[0] + t * (ends[1] - ends[0])), axis=2).min(1)
    distance, point, _ = ClosestPoints(TriMesh(V, np.array([[0, 1, 2]], np.int32))).closest(P)
    np.testing.assert_allclose(distance, expected, atol=1e-4)
    np.testing.assert_allclose(np.linalg.norm(point - P, axis=1), distance, atol=1e-12)


def test_slivers_keep_their_distance():
    V = np.array([[0, 0, 0], [1, 0, 0], [0.3, 1e-9, 0]])
    P = np.array([[0.5, 0.0, 0.25], [0.5, -0.1, 0]])
    distance = ClosestPoints(TriMesh(V, np.array([[0, 1, 2]], np.int32))).closest(P)[0]
    np.testing.assert_allclose(distance, [0.25, 0.1], atol=1e-8)


def test_ten_thousand_faces_in_one_place_end_in_one_leaf_or_halves():
    V = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    mesh = TriMesh(V, np.tile(np.array([[0, 1, 2]], np.int32), (10_000, 1)))
    distance, _, face = ClosestPoints(mesh).closest(np.array([[0.2, 0.2, 1.0]]))
    assert distance[0] == pytest.approx(1.0) and 0 <= face[0] < 10_000


def test_answers_do_not_depend_on_the_order_of_the_points_or_the_run():
    mesh = torus()
    P = np.random.default_rng(5).normal(size=(3000, 3))
    shuffle = np.random.default_rng(6).permutation(len(P))
    first, again = ClosestPoints(mesh).closest(P), ClosestPoints(mesh).closest(P)
    shuffled = ClosestPoints(mesh).closest(P[shuffle])
    assert all((a == b).all() for a, b in zip(first, again, strict=True))
    assert (first[0][shuffle] == shuffled[0]).all()


def test_no_points_give_empty_answers():
    distance, point, face = ClosestPoints(torus()).closest(np.zeros((0, 3)))
    assert distance.shape == (0,) and point.shape == (0, 3) and face.shape == (0,)


@pytest.mark.parametrize("bad", [np.zeros(3), np.zeros((2, 2)), np.full((2, 3), np.nan), np.full((2, 3), np.inf)])
def test_points_that_are_not_finite_triples_are_refused(bad):
    with pytest.raises(MeshError, match="finite points"):
        ClosestPoints(torus()).closest(bad)
