import igl
import numpy as np
import pytest
from scipy.spatial import cKDTree

from benchmarks.methods import schemes
from npm_blender.core.mesh.subdivision import Level
from npm_blender.core.mesh.triangle_mesh import TriMesh
from tests.meshes.shapes import bumpy, grid, icosphere, torus

BOTH = (schemes.loop, schemes.butterfly)
SHAPES = {"closed": bumpy(1), "open": grid(6), "genus 1": torus(8, 6), "fan": TriMesh(
    np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, -1, 0.5]], float), np.array([[0, 1, 2], [0, 2, 3]], np.int32))}


def level_of(mesh):
    return Level.of(mesh.F, len(mesh.V))


def regular(n=10):
    """A flat grid of valence 6 inside, its vertices as integers."""
    x, y = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
    return np.stack([x, y], 2).reshape(-1, 2).astype(float), grid(n).F


@pytest.mark.parametrize("scheme", BOTH)
@pytest.mark.parametrize("name", SHAPES)
def test_an_affine_map_before_is_the_same_after(scheme, name):
    mesh = SHAPES[name]
    S = scheme(level_of(mesh))
    A, t = np.array([[1, 2, 0], [0, -1, 3], [0.5, 0, 1]]), np.array([5, -2, 1])
    np.testing.assert_allclose(S @ (mesh.V @ A + t), S @ mesh.V @ A + t, atol=1e-12)


@pytest.mark.parametrize("name", SHAPES)
def test_butterfly_keeps_the_vertices_that_there_are(name):
    mesh = SHAPES[name]
    np.testing.assert_array_equal((schemes.butterfly(level_of(mesh)) @ mesh.V)[: len(mesh.V)], mesh.V)


@pytest.mark.parametrize("scheme", BOTH)
def test_a_regular_plane_keeps_its_coordinates(scheme):
    V, F = regular()
    level = Level.of(F, len(V))
    fine, edges = scheme(level) @ V, level.edges
    inner = (np.abs(V - 5) < 5).all(1)
    np.testing.assert_allclose(fine[: len(V)][inner], V[inner], atol=1e-12)
    middle = (V[edges[:, 0]] + V[edges[:, 1]]) / 2
    deep = (np.abs(middle - 5) < 4).all(1)
    np.testing.assert_allclose(fine[len(V) :][deep], middle[deep], atol=1e-12)


def test_butterfly_reproduces_cubics_where_the_mesh_is_regular():
    V, F = regular()
    level = Level.of(F, len(V))
    f = lambda p: p[:, 0] ** 3 - 2 * p[:, 0] * p[:, 1] ** 2 + p[:, 1] ** 2
    middle = (V[level.edges[:, 0]] + V[level.edges[:, 1]]) / 2
    deep = (np.abs(middle - 5) < 3).all(1)
    np.testing.assert_allclose((schemes.butterfly(level) @ f(V))[len(V) :][deep], f(middle)[deep], atol=1e-9)


def test_loop_is_libigls_where_all_valences_are_6():  # libigl has Warren's weights elsewhere, we have Loop's
    mesh = SHAPES["genus 1"]
    level = level_of(mesh)
    V, F = igl.loop(mesh.V, mesh.F.astype(np.int64), 1)
    ours = schemes.loop(level) @ mesh.V
    far, nearest = cKDTree(ours[level.subdivided().F].mean(1)).query(V[F].mean(1))
    assert far.max() < 1e-12 and len(np.unique(nearest)) == len(F)


@pytest.mark.parametrize("name", SHAPES)
def test_repeated_loop_comes_to_the_limit(name):
    mesh = SHAPES[name]
    V, level = mesh.V, level_of(mesh)
    limit = schemes.loop_limit(level) @ V
    for _ in range(4):
        V, level = schemes.loop(level) @ V, level.subdivided()
    size = np.abs(mesh.V - limit).max()
    assert np.abs(V[: len(limit)] - limit).max() < 0.02 * size


@pytest.mark.parametrize("scheme", BOTH)
def test_borders_depend_on_borders_only(scheme):
    mesh = SHAPES["open"]
    level = level_of(mesh)
    rim = level.edge_halfedge[:, 0] == level.edge_halfedge[:, 1]
    on = np.zeros(level.n, bool)
    on[level.edges[rim]] = True
    bent = mesh.V + np.where(on, 0, 1)[:, None] * np.random.default_rng(0).normal(size=mesh.V.shape)
    rows = np.concatenate([on, rim])
    np.testing.assert_array_equal((scheme(level) @ bent)[rows], (scheme(level) @ mesh.V)[rows])


@pytest.mark.parametrize("scheme", BOTH)
def test_a_sphere_stays_round(scheme):
    fine = schemes.subdivided(icosphere(1), scheme)
    radius = np.linalg.norm(fine.V, axis=1)
    assert len(fine.F) == 80 * 64 and np.ptp(radius) < 0.03


def test_large_bases_get_fewer_levels():
    assert [schemes.steps(n) for n in (400, 1_000, 2_000, 7_000, 50_000)] == [3, 3, 2, 1, 1]
