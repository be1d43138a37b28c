import numpy as np
import pytest

from npm_blender.core.cleaning.cleanup import clean
from npm_blender.core.cleaning.edge_groups import EdgeGroups
from npm_blender.core.cleaning.t_junctions import split_at_junctions
from npm_blender.core.geometry.closest_point import ClosestPoints
from npm_blender.core.mesh import directed_edges
from tests.meshes.dirty_meshes import (
    glued,
    mesh,
    unequal_sides,
)


def groups(m):
    return EdgeGroups.of(m.F, len(m.V))


def test_both_sides_of_a_crack_get_the_vertices_of_the_other():
    m = unequal_sides()
    after, splits = split_at_junctions(m.V, groups(m), 1e-9)
    assert splits == 16 and (after.sizes == 2).all()
    distance, _, _ = ClosestPoints(m).closest(m.V[after.F].mean(1))
    assert distance.max() < 1e-12 and mesh(m.V, after.F).face_areas().sum() == pytest.approx(6)


def test_offset_rows_are_split_on_both_sides():
    """Two strips along the x axis, one with vertices at sixths of it, one at quarters."""
    def strip(n, y):
        x = np.arange(n + 1) / n
        V = np.concatenate([np.column_stack([x, 0 * x, 0 * x]), np.column_stack([x, 0 * x + y, 0 * x])])
        i = np.arange(n)
        F = np.concatenate([np.stack([i, i + 1, i + n + 2], 1), np.stack([i, i + n + 2, i + n + 1], 1)])
        return mesh(V, F if y > 0 else F[:, ::-1])
    m = glued(strip(6, 1), strip(4, -1))
    after, splits = split_at_junctions(m.V, groups(m), 1e-6)
    assert splits == 2 + 4  # sixths that are no quarters, quarters that are no sixths, with one of each in the middle
    start, end = directed_edges(after.F)[after.border].T
    y = m.V[start, 1] + m.V[end, 1]
    assert (y != 0).all()  # no border is left on the axis
    cleaned, report = clean(m)
    assert report.after.components == 1 and report.after.border_loops == 1 and "T-junctions" in report.summary


def test_a_vertex_beside_an_edge_does_not_split_it():
    m = unequal_sides()
    V = m.V.copy()
    V[(V[:, 2] == 1) & (np.abs(V[:, 0] - 0.125) < 1e-9) & (V[:, 1] == 0), 1] = -1e-3
    after, splits = split_at_junctions(V, groups(m), 1e-6)
    assert splits == 15


def test_many_vertices_on_one_edge():
    n = 200
    fan = mesh([[0, 0, 0], [1, 0, 0], [0.5, -1, 0]], [[1, 0, 2]])
    t = np.arange(n + 1) / n
    V = np.concatenate([np.column_stack([t, 0 * t, 0 * t]), [[0.5, 1, 0]]])
    comb = mesh(V, [[i, i + 1, n + 1] for i in range(n)])
    m = glued(fan, comb)
    cleaned, report = clean(m)
    assert f"closed {n - 1} T-junctions" in report.summary and report.after.border_edges == 4
    assert cleaned.face_areas().sum() == pytest.approx(1)


def test_a_face_is_not_split_at_its_own_corner():
    flat = mesh([[0, 0, 0], [2, 0, 0], [1, 0, 0], [0, -1, 0], [2, -1, 0]], [[0, 1, 2], [0, 3, 2], [2, 4, 1]])
    after, splits = split_at_junctions(flat.V, groups(flat), 1e-6)
    assert splits == 0 and after.F is flat.F
