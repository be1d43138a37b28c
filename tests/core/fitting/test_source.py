"""The source: distances to it, and how far another mesh is off, the worse way."""
import numpy as np
import pytest

from npm_blender.core.errors import MeshError
from npm_blender.core.fitting import Source
from npm_blender.core.fitting.source import closest, unit_vectors
from npm_blender.core.geometry import ClosestPoints
from npm_blender.core.mesh import TriMesh
from tests.core.fitting.samples import SHAPES, unit
from tests.meshes.shapes import grid

MESH = SHAPES["closed"][0]


def test_points_are_of_the_surface_and_the_same_every_time():
    one, two = Source(MESH, 500), Source(MESH, 500)
    assert np.array_equal(one.points, two.points) and np.array_equal(one.rank, two.rank)
    assert ClosestPoints(MESH).closest(one.points)[0].max() < 1e-12
    assert np.allclose(np.linalg.norm(one.normals, axis=1), 1) and sorted(one.rank) == list(range(500))


def test_distances_grow_along_the_vectors():
    source = Source(MESH, 500)
    P = source.points + 0.01 * np.random.default_rng(0).normal(size=(500, 3))
    distance, away = source.closest(P)
    assert np.allclose(np.linalg.norm(away, axis=1), 1)
    further, _ = source.closest(P + 1e-6 * away)
    assert np.allclose(further - distance, 1e-6, atol=1e-8)


def test_on_the_surface_the_normal_takes_the_place_of_a_direction():
    source = Source(MESH, 50)
    _, away = source.closest(source.points)
    assert np.allclose(away, source.normals)
    assert unit_vectors(np.zeros((1, 3)), np.zeros(1), np.array([[0, 1.0, 0]])).tolist() == [[0, 1, 0]]


def test_the_error_is_the_larger_of_both_ways():
    whole = unit(grid(12))
    half = TriMesh(whole.V, whole.F[whole.V[whole.F].mean(1)[:, 0] < 0])
    source = Source(whole, 4_000)
    lifted = TriMesh(whole.V + [0, 0, 0.01], whole.F)
    assert source.error(whole, 2_000) < 1e-12
    assert source.error(half, 2_000) > 0.05  # all of it is on the source, which it does not cover
    assert Source(half, 4_000).error(whole, 2_000) > 0.05
    assert 0.005 < source.error(lifted, 2_000) <= 0.01
    assert source.error(lifted, 2_000, ClosestPoints(lifted)) == source.error(lifted, 2_000)


def test_pieces_are_looked_up_as_one():
    surface = ClosestPoints(MESH)
    P = np.random.default_rng(0).random((40_000, 3))
    for found, whole in zip(closest(surface, P)[:2], surface.closest(P)[:2], strict=True):
        assert np.allclose(found, whole, atol=1e-12)


def test_a_mesh_without_area_is_no_source():
    with pytest.raises(MeshError):
        Source(TriMesh(np.zeros((3, 3)), np.array([[0, 1, 2]], np.int32)))
