"""Creases and corners from level to level; how much a line turns."""
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npm_blender.core.mesh import Level, Sharp, turns
from tests.meshes.shapes import grid, icosphere, torus

SHAPES = {"sphere": icosphere(1), "torus": torus(8, 6), "open": grid(4)}
NAMES = pytest.mark.parametrize("name", SHAPES)


def case(name, share=0.3, seed=0):
    """A level, and creases and corners of it drawn at random."""
    level, rng = Level.of(SHAPES[name].F, len(SHAPES[name].V)), np.random.default_rng(seed)
    return level, Sharp(rng.random(len(level.edges)) < share, rng.random(level.n) < share)


@NAMES
def test_both_halves_of_a_crease_are_creases_and_no_other_edge_is(name):
    level, sharp = case(name)
    after, found = level.subdivided(), sharp.subdivided(level)
    old, new = after.edges.T  # the smaller number first
    edge = new - level.n
    is_half = old < level.n
    assert (edge >= 0).all() and is_half.sum() == 2 * len(level.edges)
    assert (old[is_half, None] == level.edges[edge[is_half]]).any(1).all()
    assert np.array_equal(found.edges, is_half & sharp.edges[edge])
    assert found.edges.sum() == 2 * sharp.edges.sum() and found.edges.dtype == bool


@NAMES
def test_corners_stay_and_no_new_vertex_is_one(name):
    level, sharp = case(name)
    found = sharp.subdivided(level)
    assert np.array_equal(found.corners[: level.n], sharp.corners)
    assert not found.corners[level.n:].any() and len(found.corners) == level.subdivided().n


@NAMES
def test_new_vertices_of_creases_have_two_and_old_ones_as_many_as_before(name):
    level, sharp = case(name)
    after, found = level.subdivided(), sharp.subdivided(level)
    count = [np.bincount(at.edges[s.edges].reshape(-1), minlength=at.n) for at, s in ((level, sharp), (after, found))]
    assert np.array_equal(count[1], np.concatenate([count[0], 2 * sharp.edges]))


@NAMES
def test_lines_are_the_creases_and_the_border(name):
    level, sharp = case(name)
    border = Sharp(sharp.edges & False, sharp.corners).lines(level)
    assert border.sum() == (16 if name == "open" else 0)
    assert np.array_equal(sharp.lines(level), sharp.edges | border)
    after = level.subdivided()
    assert sharp.subdivided(level).lines(after).sum() == 2 * sharp.lines(level).sum()


@given(st.floats(-180, 180), st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))
def test_a_turn_depends_on_the_angle_alone(angle, before, after):
    w = np.radians(angle)
    V = np.array([[-before, 0, 0], [0, 0, 0], [after * np.cos(w), after * np.sin(w), 0]])
    assert turns(V, np.array([[0, 1], [1, 2]])) == pytest.approx([1, 4 * np.sin(w / 2) ** 2, 1], abs=1e-12)
    assert turns(V, np.array([[2, 1], [1, 0]])) == pytest.approx([1, 4 * np.sin(w / 2) ** 2, 1], abs=1e-12)


def test_edges_without_length_turn_nothing():
    assert turns(np.zeros((3, 3)), np.array([[0, 1], [1, 2]])).tolist() == [0, 0, 0]
    assert turns(np.eye(3), np.zeros((0, 2), int)).tolist() == [0, 0, 0]
