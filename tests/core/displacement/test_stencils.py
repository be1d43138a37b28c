"""The steps of the schemes: midpoints, Loop's, and what lies between."""
import numpy as np
import pytest

from npm_blender.core.displacement import SMOOTHEST, stencil_of
from npm_blender.core.mesh import hierarchy, midpoints
from tests.meshes.shapes import grid, icosphere, torus

SHAPES = {"closed": icosphere(1), "open": grid(5), "torus": torus(8, 6)}
ALL = [(name, smooth) for name in SHAPES for smooth in (0, 3, SMOOTHEST)]


def level_of(name):
    mesh = SHAPES[name]
    return mesh, hierarchy(mesh.F, len(mesh.V), 1)[0]


@pytest.mark.parametrize("name", SHAPES)
def test_the_least_smooth_scheme_is_midpoints(name):
    mesh, level = level_of(name)
    assert np.allclose(stencil_of(level, 0).apply(mesh.V), midpoints(mesh.V, level), atol=1e-15)


@pytest.mark.parametrize(("name", "smooth"), ALL)
def test_a_step_commutes_with_every_affine_map(name, smooth):
    mesh, level = level_of(name)
    step, A = stencil_of(level, smooth), np.random.default_rng(0).normal(size=(3, 3))
    assert np.allclose(step.apply(mesh.V @ A + 5), step.apply(mesh.V) @ A + 5, atol=1e-12)


@pytest.mark.parametrize(("name", "smooth"), ALL)
def test_the_rows_of_the_matrix_are_the_step(name, smooth):
    mesh, level = level_of(name)
    step = stencil_of(level, smooth)
    start, index, weight = step.rows()
    assert len(start) == level.n + len(level.edges) + 1 and (np.diff(start) > 0).all()
    sums = np.add.reduceat(weight, start[:-1])
    assert np.allclose(sums, 1, atol=1e-14)
    X = np.add.reduceat(weight[:, None] * mesh.V[index], start[:-1])
    assert np.allclose(X, step.apply(mesh.V), atol=1e-14)


@pytest.mark.parametrize("name", SHAPES)
def test_schemes_between_are_the_blend_of_both(name):
    mesh, level = level_of(name)
    least, most = (stencil_of(level, smooth).apply(mesh.V) for smooth in (0, SMOOTHEST))
    assert np.allclose(stencil_of(level, 3).apply(mesh.V), least + (most - least) * 3 / SMOOTHEST, atol=1e-14)


def test_loops_weights():
    mesh, level = level_of("torus")  # every vertex has six neighbours
    step = stencil_of(level, SMOOTHEST)
    assert np.allclose(step.own, 5 / 8) and np.allclose(step.around, 1 / 16)
    assert np.allclose(step.end, 3 / 8) and np.allclose(step.across, 1 / 8)


def test_a_border_is_a_cubic_spline_of_its_own():
    mesh, level = level_of("open")
    step = stencil_of(level, SMOOTHEST)
    moved = mesh.V.copy()
    inner = np.ones(level.n, bool)
    edges = level.edges[level.edge_halfedge[:, 0] == level.edge_halfedge[:, 1]]
    inner[edges.reshape(-1)] = False
    moved[inner] += np.random.default_rng(1).normal(size=(inner.sum(), 3))
    a, b = step.apply(mesh.V), step.apply(moved)
    on = np.concatenate([~inner, level.edge_halfedge[:, 0] == level.edge_halfedge[:, 1]])
    assert np.array_equal(a[on], b[on]) and (a[~on] != b[~on]).any()
    v = edges[0, 0]
    beside = edges[(edges == v).any(1)]
    assert np.allclose(a[v], 0.75 * mesh.V[v] + 0.125 * sum(mesh.V[e[e != v][0]] for e in beside), atol=1e-14)


def test_a_smooth_scheme_makes_a_sphere_of_a_solid():
    mesh = icosphere(0)
    X = mesh.V
    for level in hierarchy(mesh.F, len(mesh.V), 4)[:-1]:
        X = stencil_of(level, SMOOTHEST).apply(X)
    radius = np.linalg.norm(X, axis=1)
    assert radius.std() < 0.02 * radius.mean()
