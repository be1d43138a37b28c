"""From integers to vertices: level by level, along the normals there."""
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from npm_blender.core.displacement import SMOOTHEST, DisplacedSurface
from npm_blender.core.displacement.displaced_surface import AHEAD
from npm_blender.core.fitting import sharp_of
from npm_blender.core.mesh import Level, TriMesh
from tests.meshes.dirty_meshes import box
from tests.meshes.shapes import grid, icosphere, torus

SHAPES = {"closed": icosphere(0), "open": grid(3), "torus": torus(6, 5)}
ALL = [(name, smooth) for name in SHAPES for smooth in (0, 4, SMOOTHEST)]


def surface(name, smooth=SMOOTHEST, levels=3):
    mesh = SHAPES[name]
    return mesh.V, DisplacedSurface(mesh.F, len(mesh.V), levels, smooth)


def some_moves(of, seed=0):
    return np.random.default_rng(seed).normal(size=int(of.first[-1])) * 0.01


@pytest.mark.parametrize(("name", "smooth"), ALL)
def test_levels_have_four_times_the_faces_and_a_vertex_more_for_each_edge(name, smooth):
    V0, of = surface(name, smooth)
    built = of.build(V0, some_moves(of))
    for i, (X, N) in enumerate(zip(built.X, built.N, strict=True)):
        assert len(of.hierarchy[i].F) == len(SHAPES[name].F) * 4**i
        assert len(X) == of.first[i + 1] == of.hierarchy[i].n and len(N) == of.first[i + 1] - of.first[i]
        if i:
            assert len(X) == of.hierarchy[i - 1].n + len(of.hierarchy[i - 1].edges)


@pytest.mark.parametrize(("name", "smooth"), ALL)
def test_fewer_levels_are_the_first_of_more(name, smooth):
    V0, of = surface(name, smooth)
    moves, short = some_moves(of), surface(name, smooth, 2)[1]
    assert all(np.array_equal(a, b) for a, b in zip(of.build(V0, moves).X, short.build(V0, moves).X, strict=False))
    assert np.array_equal(of.build(V0, moves, 1).X[-1], of.build(V0, moves).X[1])
    assert all(map(np.array_equal, of.with_levels(1).build(V0, moves).X, of.build(V0, moves).X[:2]))


@pytest.mark.parametrize(("name", "smooth"), ALL)
def test_it_commutes_with_motion_and_scale(name, smooth):
    V0, of = surface(name, smooth)
    moves = some_moves(of)
    q, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    q *= np.sign(np.linalg.det(q))
    a, b = of.build(V0, moves).X[-1], of.build(0.5 * V0 @ q.T + 3, 0.5 * moves).X[-1]
    assert np.abs(0.5 * a @ q.T + 3 - b).max() < 1e-12


@pytest.mark.parametrize("name", SHAPES)
def test_vertices_move_along_their_unit_normals_and_no_other_does(name):
    V0, of = surface(name, levels=1)
    none = np.zeros(int(of.first[-1]))
    plain, one = of.build(V0, none), none.copy()
    v = int(of.first[1]) + 2
    one[v] = 0.25
    built = of.build(V0, one)
    assert np.allclose(np.linalg.norm(built.N[1], axis=1), 1, atol=1e-12)
    assert np.allclose(built.X[1][v] - plain.X[1][v], 0.25 * plain.N[1][v - of.first[1]], atol=1e-15)
    others = np.arange(of.first[-1]) != v
    assert np.array_equal(built.X[1][others], plain.X[1][others])


def test_a_move_outward_makes_a_closed_surface_larger():
    V0, of = surface("closed")
    size = [np.linalg.norm(of.build(V0, np.full(int(of.first[-1]), m)).X[-1], axis=1).mean() for m in (-0.02, 0.0, 0.02)]
    assert size == sorted(size)


@pytest.mark.parametrize("name", SHAPES)
def test_a_level_is_shown_where_its_vertices_are_two_levels_further(name):
    V0, of = surface(name, levels=4)
    moves = some_moves(of)
    for level in range(5):
        further = of.build(V0, moves, min(level + AHEAD, 4)).X[-1]
        assert np.array_equal(of.shown(V0, moves, level), further[: of.hierarchy[level].n])
    sharp = replace(of, smooth=0)
    assert np.array_equal(sharp.shown(V0, moves, 1), sharp.build(V0, moves).X[1])


def test_a_level_that_is_shown_is_nearer_to_the_surface_than_its_cage():
    V0, of = surface("closed", levels=4)
    none = np.zeros(int(of.first[-1]))
    finest = np.linalg.norm(of.build(V0, none).X[-1], axis=1).mean()
    cage, shown = (np.linalg.norm(V, axis=1).mean() for V in (V0, of.shown(V0, none, 0)))
    assert abs(shown - finest) < 0.2 * abs(cage - finest)


def test_a_vertex_whose_faces_cancel_out_does_not_move():
    """Both sides of one triangle: normals cancel, and nothing is divided by zero."""
    V0 = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    of = DisplacedSurface(np.array([[0, 1, 2], [0, 2, 1]]), 3, 1, 0)
    X = of.build(V0, np.ones(int(of.first[-1]))).X[-1]
    assert np.isfinite(X).all() and not X[:, 2].any()


def test_flat_stays_flat():
    V0, of = surface("open")
    V0 = V0 * [1, 1, 0]
    X = of.build(V0, np.zeros(int(of.first[-1]))).X[-1]
    assert not X[:, 2].any()
    sharp = replace(of, smooth=0).build(V0, np.zeros(int(of.first[-1]))).X[-1]
    assert TriMesh(sharp, of.hierarchy[-1].F).face_areas().sum() == pytest.approx(TriMesh(V0, of.F0).face_areas().sum())


def test_it_needs_no_compiler():
    code = ("import sys; from npm_blender.core.displacement import DisplacedSurface; "
            "sys.exit(any(m in sys.modules for m in ('numba', 'torch', 'scipy')))")
    assert subprocess.run([sys.executable, "-c", code], cwd=Path(__file__).parents[3]).returncode == 0


def boxed(levels=3, smooth=SMOOTHEST):
    """A box whose edges are creases."""
    mesh = box(2)
    return mesh.V, DisplacedSurface(mesh.F, len(mesh.V), levels, smooth, sharp_of(mesh.V, Level.of(mesh.F, len(mesh.V)), 40))


@pytest.mark.parametrize("smooth", [0, 4, SMOOTHEST])
def test_a_box_with_creases_stays_a_box_at_every_level(smooth):
    V0, of = boxed(smooth=smooth)
    none = np.zeros(int(of.first[-1]))
    for level, X in enumerate(of.build(V0, none).X):
        for V in (X, of.shown(V0, none, level)):
            assert np.abs(np.abs(V - 0.5).max(1) - 0.5).max() < 1e-14
            assert TriMesh(V, of.hierarchy[level].F).face_areas().sum() == pytest.approx(6)
    without = replace(of, sharp=None).build(V0, none).X[-1]
    assert smooth == 0 or np.abs(np.abs(without - 0.5).max(1) - 0.5).max() > 0.01


def test_fewer_levels_keep_their_creases():
    V0, of = boxed()
    moves = some_moves(of)
    assert all(map(np.array_equal, of.with_levels(2).build(V0, moves).X, of.build(V0, moves).X[:3]))
    assert of.with_levels(2).levels == 2 and of.with_levels(2).sharp is of.sharp
