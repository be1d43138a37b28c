"""Creases by the angle of faces, corners by the angle of lines."""
import numpy as np
import pytest

from npm_blender.core.fitting import sharp_of
from npm_blender.core.mesh import Level, TriMesh
from tests.meshes.dirty_meshes import box
from tests.meshes.shapes import bumpy, grid

SHAPES = {"a box": box(3), "a bumpy sphere": bumpy(2), "an open grid": grid(6)}


def found_on(mesh, angle):
    level = Level.of(mesh.F, len(mesh.V))
    return level, sharp_of(mesh.V, level, angle)


@pytest.mark.parametrize("angle", [25, 40, 60, 89])
def test_the_edges_of_a_box_are_creases_that_go_straight_on(angle):
    mesh = box(3)
    level, found = found_on(mesh, angle)
    on = ((mesh.V == 0) | (mesh.V == 1))[level.edges].all(1)  # (e, 3): lies in a side across this axis
    assert np.array_equal(found.edges, on.sum(1) == 2)
    assert found.edges.sum() == 12 * 3 and not found.corners.any()  # three meet in each corner: it stays as it is


def test_a_box_has_no_fold_beyond_its_right_angles():
    assert not found_on(box(3), 91)[1].edges.any()


def test_a_bumpy_sphere_has_no_creases_and_no_corners():
    found = found_on(bumpy(3), 60)[1]
    assert not found.edges.any() and not found.corners.any()


def test_an_open_grid_has_four_corners_and_no_creases():
    mesh = grid(6)
    found = found_on(mesh, 40)[1]
    assert not found.edges.any()
    assert np.flatnonzero(found.corners).tolist() == np.flatnonzero((np.abs(mesh.V[:, :2]) == 1).all(1)).tolist()


def test_where_a_line_of_creases_turns_is_a_corner():
    """A flat quarter of a sheet whose outside falls off, round a cone at the middle."""
    flat = grid(4, 0.0)
    x, y = np.maximum(flat.V[:, 0], 0), np.maximum(flat.V[:, 1], 0)
    mesh = TriMesh(np.stack([flat.V[:, 0], flat.V[:, 1], -np.hypot(x, y)], 1), flat.F)
    level, found = found_on(mesh, 40)
    middle = int(np.flatnonzero((mesh.V == 0).all(1))[0])
    assert found.edges.sum() == 4 and (level.edges[found.edges] == middle).any(1).sum() == 2
    assert found.corners[middle] and found.corners.sum() == 5
    ends = np.bincount(level.edges[found.lines(level)].reshape(-1)) > 2
    assert ends.sum() == 2 and not found.corners[ends].any()  # where the creases meet the border


@pytest.mark.parametrize("name", SHAPES)
def test_a_larger_angle_leaves_fewer_creases(name):
    before = None
    for angle in (5, 15, 25, 40, 60, 95):
        edges = found_on(SHAPES[name], angle)[1].edges
        assert before is None or (edges <= before).all()
        before = edges


@pytest.mark.parametrize("name", SHAPES)
def test_motion_and_scale_change_nothing(name):
    mesh = SHAPES[name]
    q, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    q *= np.sign(np.linalg.det(q))
    a, b = found_on(mesh, 25)[1], found_on(TriMesh(0.1 * mesh.V @ q.T + 3, mesh.F), 25)[1]
    assert np.array_equal(a.edges, b.edges) and np.array_equal(a.corners, b.corners)


def test_faces_without_area_are_no_reason_to_fail():
    mesh = grid(3)
    found = found_on(TriMesh(np.zeros_like(mesh.V), mesh.F), 40)[1]
    assert not found.corners.any() and len(found.edges) == len(Level.of(mesh.F, len(mesh.V)).edges)
