"""The steps of the schemes: midpoints, Loop's, and what lies between; creases and corners stay sharp."""
import numpy as np
import pytest

from npm_blender.core.displacement import SMOOTHEST, stencil_of
from npm_blender.core.fitting import sharp_of
from npm_blender.core.mesh import Level, Sharp, hierarchy, midpoints
from tests.meshes.dirty_meshes import box
from tests.meshes.shapes import grid, icosphere, torus

SHAPES = {"closed": icosphere(1), "open": grid(5), "torus": torus(8, 6)}
ALL = [(name, smooth) for name in SHAPES for smooth in (0, 3, SMOOTHEST)]
CREASES = pytest.mark.parametrize("share", [None, 0.1, 0.5])


def level_of(name):
    mesh = SHAPES[name]
    return mesh, hierarchy(mesh.F, len(mesh.V), 1)[0]


def some_sharp(level, share=0.3, seed=0):
    """Creases and corners drawn at random; None of share None."""
    rng = np.random.default_rng(seed)
    return None if share is None else Sharp(rng.random(len(level.edges)) < share, rng.random(level.n) < share / 3)


def boxed():
    """A cube, its level, and its twelve edges as creases."""
    mesh = box(2)
    level = Level.of(mesh.F, len(mesh.V))
    return mesh.V, level, sharp_of(mesh.V, level, 40)


def lines_at(level, sharp):
    """How many borders and creases meet in each vertex."""
    return np.bincount(level.edges[sharp.lines(level)].reshape(-1), minlength=level.n)


@pytest.mark.parametrize("name", SHAPES)
def test_the_least_smooth_scheme_is_midpoints(name):
    mesh, level = level_of(name)
    assert np.allclose(stencil_of(level, 0).apply(mesh.V), midpoints(mesh.V, level), atol=1e-15)


@CREASES
@pytest.mark.parametrize(("name", "smooth"), ALL)
def test_a_step_commutes_with_every_affine_map(name, smooth, share):
    mesh, level = level_of(name)
    step, A = stencil_of(level, smooth, some_sharp(level, share)), np.random.default_rng(0).normal(size=(3, 3))
    assert np.allclose(step.apply(mesh.V @ A + 5), step.apply(mesh.V) @ A + 5, atol=1e-12)


@CREASES
@pytest.mark.parametrize(("name", "smooth"), ALL)
def test_the_rows_of_the_matrix_are_the_step(name, smooth, share):
    mesh, level = level_of(name)
    step = stencil_of(level, smooth, some_sharp(level, share))
    start, index, weight = step.rows()
    assert len(start) == level.n + len(level.edges) + 1 and (np.diff(start) > 0).all()
    sums = np.add.reduceat(weight, start[:-1])
    assert np.allclose(sums, 1, atol=1e-14)
    X = np.add.reduceat(weight[:, None] * mesh.V[index], start[:-1])
    assert np.allclose(X, step.apply(mesh.V), atol=1e-14)


@CREASES
@pytest.mark.parametrize("name", SHAPES)
def test_schemes_between_are_the_blend_of_both(name, share):
    mesh, level = level_of(name)
    sharp = some_sharp(level, share)
    least, most = (stencil_of(level, smooth, sharp).apply(mesh.V) for smooth in (0, SMOOTHEST))
    assert np.allclose(stencil_of(level, 3, sharp).apply(mesh.V), least + (most - least) * 3 / SMOOTHEST, atol=1e-14)


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


@pytest.mark.parametrize(("name", "smooth"), ALL)
def test_no_creases_are_as_none(name, smooth):
    mesh, level = level_of(name)
    none = Sharp(np.zeros(len(level.edges), bool), np.zeros(level.n, bool))
    assert all(np.array_equal(a, b) for a, b in zip(stencil_of(level, smooth), stencil_of(level, smooth, none), strict=True))


def test_midpoints_know_no_creases():
    mesh, level = level_of("torus")
    assert np.array_equal(stencil_of(level, 0, some_sharp(level)).apply(mesh.V), stencil_of(level, 0).apply(mesh.V))


def test_the_curve_of_a_crease_depends_on_its_vertices_alone():
    V, level, sharp = boxed()
    on, step = lines_at(level, sharp) > 0, stencil_of(level, SMOOTHEST, sharp)
    moved = V.copy()
    moved[~on] += np.random.default_rng(1).normal(size=((~on).sum(), 3))
    a, b = step.apply(V), step.apply(moved)
    on = np.concatenate([on, sharp.edges])
    assert np.array_equal(a[on], b[on]) and (a[~on] != b[~on]).any(1).all()


def test_the_curve_of_a_crease_is_a_cubic_spline():
    mesh, level = level_of("torus")
    ring = np.arange(6)  # once round the torus
    edges = (level.edges < 6).all(1) & np.isin(np.diff(level.edges, axis=1)[:, 0], (1, 5))
    assert edges.sum() == 6
    X = stencil_of(level, SMOOTHEST, Sharp(edges, np.zeros(level.n, bool))).apply(mesh.V)
    assert np.allclose(X[ring], 0.75 * mesh.V[ring] + 0.125 * (mesh.V[(ring - 1) % 6] + mesh.V[(ring + 1) % 6]), atol=1e-14)
    assert np.allclose(X[level.n:][edges], mesh.V[level.edges[edges]].mean(1), atol=1e-14)


@pytest.mark.parametrize("name", SHAPES)
def test_corners_and_vertices_in_which_more_than_two_lines_meet_stay(name):
    mesh, level = level_of(name)
    sharp = some_sharp(level, 0.4)
    step = stencil_of(level, SMOOTHEST, sharp)
    still = sharp.corners | (lines_at(level, sharp) > 2)
    X = step.apply(mesh.V)[: level.n]
    assert np.array_equal(X[still], mesh.V[still]) and still.any() and (X != mesh.V).any(1)[~still].mean() > 0.9


def test_a_crease_that_ends_leaves_its_end_as_smooth_as_without():
    mesh, level = level_of("torus")
    sharp = Sharp(np.arange(len(level.edges)) == 7, np.zeros(level.n, bool))
    a, b = (stencil_of(level, SMOOTHEST, s).apply(mesh.V) for s in (sharp, None))
    other = np.arange(len(a)) != level.n + 7
    assert np.array_equal(a[other], b[other])
    assert np.allclose(a[~other], mesh.V[level.edges[7]].mean(0), atol=1e-15) and not np.allclose(a[~other], b[~other])


def test_a_border_goes_on_as_before_beside_creases_and_stays_where_one_meets_it():
    mesh, level = level_of("open")
    border = level.edge_halfedge[:, 0] == level.edge_halfedge[:, 1]
    on = np.zeros(level.n, bool)
    on[level.edges[border].reshape(-1)] = True
    sharp = Sharp(~border & (np.random.default_rng(3).random(len(border)) < 0.3), np.zeros(level.n, bool))
    met = lines_at(level, sharp) > 2
    a, b = (stencil_of(level, SMOOTHEST, s).apply(mesh.V) for s in (sharp, None))
    same = np.concatenate([on & ~met, border])
    assert np.array_equal(a[same], b[same])
    assert np.array_equal(a[: level.n][on & met], mesh.V[on & met]) and (on & met).any() and (on & ~met).any()


def test_a_corner_of_the_border_stays_and_the_others_do_not():
    mesh, level = level_of("open")
    sharp = sharp_of(mesh.V, level, 60)
    X = stencil_of(level, SMOOTHEST, sharp).apply(mesh.V)[: level.n]
    assert sharp.corners.sum() == 4 and np.array_equal(X[sharp.corners], mesh.V[sharp.corners])
    assert not np.array_equal(X, stencil_of(level, SMOOTHEST).apply(mesh.V)[: level.n])
