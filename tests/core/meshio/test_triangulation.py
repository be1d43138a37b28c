import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.meshio.triangulation import triangulate

CONCAVE = {
    "arrow quad": [[0, 0], [2, 1], [0, 2], [0.5, 1]],
    "arrow quad turned": [[0.5, 1], [0, 0], [2, 1], [0, 2]],
    "L": [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]],
    "comb": [[0, 0], [7, 0], [7, 3], [6, 1], [5, 3], [4, 1], [3, 3], [2, 1], [1, 3], [0, 1]],
    "corner on an edge": [[0, 0], [1, 0], [2, 0], [2, 2], [0, 2]],
}


def area(V, F):
    return np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]])


@pytest.mark.parametrize("name", CONCAVE)
@pytest.mark.parametrize("turn", [0, 1, 2])
def test_concave_polygons_stay_inside(name, turn):
    outline = np.array(CONCAVE[name], float)
    V = np.roll(np.column_stack([outline, np.zeros(len(outline))]), turn, 1)
    F = triangulate(V, np.arange(len(V)), np.array([len(V)]))
    x, y = outline.T
    whole = 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()
    normal = np.roll([0, 0, 1.0], turn)
    assert F.shape == (len(V) - 2, 3)
    assert (area(V, F) @ normal >= 0).all() and area(V, F).sum(0) @ normal / 2 == pytest.approx(whole)


@given(st.integers(3, 80), st.integers(0, 2**31))
@settings(max_examples=50, deadline=None)
def test_star_shaped_polygons_keep_their_area(n, seed):
    random = np.random.default_rng(seed)
    angle = (np.arange(n) + random.uniform(0.1, 0.9, n)) * 2 * np.pi / n
    V = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]) * random.uniform(0.2, 1, n)[:, None]
    F = triangulate(V, np.arange(n), np.array([n]))
    assert len(F) == n - 2 and set(F.ravel()) == set(range(n))
    assert np.abs(area(V, F)[:, 2]).sum() == pytest.approx(np.abs(area(V, F)[:, 2].sum()))


def test_points_and_lines_give_no_triangles_and_flat_polygons_do_not_hang():
    V = np.column_stack([np.arange(6.0), np.zeros(6), np.zeros(6)])
    F = triangulate(V, np.array([0, 0, 1, 0, 1, 2, 3, 4, 5, 1, 1, 1, 1, 1]), np.array([1, 2, 6, 5]))
    assert len(F) == 4 + 3


def test_a_polygon_of_very_many_corners_does_not_hang():
    """The work is linear for a round one; one that crosses itself everywhere is cut as it comes at some point."""
    n = 20_000
    angle = np.arange(n) * 2 * np.pi / n
    V = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    F = triangulate(V, np.arange(n), np.array([n]))
    assert (area(V, F)[:, 2] > 0).all() and area(V, F)[:, 2].sum() / 2 == pytest.approx(np.pi, rel=1e-6)
    V = np.random.default_rng(0).random((n, 3)) * [1, 1, 0]
    F = triangulate(V, np.arange(n), np.array([n]))
    assert len(F) == n - 2 and np.bincount(F.ravel(), minlength=n).min() > 0
