"""Samples of both ways, and the linear model of their distances."""
import numpy as np
import pytest

from npm_blender.core.displacement import SMOOTHEST
from tests.core.fitting.samples import SHAPES, none, two_way

ALL = [(name, smooth) for name in SHAPES for smooth in (0, SMOOTHEST)]


@pytest.mark.parametrize(("name", "smooth"), ALL)
def test_rows_of_the_finest_vertices_are_what_subdivision_does(name, smooth):
    fit, V0 = two_way(name, 2, smooth)
    X = fit.surface.build(V0, none(fit)).X[-1]
    rows = fit.by_level[0]
    weighted = rows.weight[:, None] * V0[rows.column]
    assert np.allclose(np.add.reduceat(weighted, rows.start[:-1]), X, atol=1e-12)
    assert len(fit.by_level) == 3 and fit.by_level[2].columns == fit.surface.first[-1] - fit.surface.first[2]


@pytest.mark.parametrize("name", SHAPES)
def test_the_mean_is_the_worse_way(name):
    fit, V0 = two_way(name)
    X = fit.surface.build(V0, none(fit)).X[-1]
    samples = fit.measured(X, 1e-4, 5_000)
    from npm_blender.core.mesh import TriMesh
    error = fit.source.error(TriMesh(X, fit.surface.hierarchy[-1].F), 5_000)
    assert samples.mean == pytest.approx(error, rel=0.15)


@pytest.mark.parametrize(("name", "smooth"), ALL)
@pytest.mark.parametrize("level", [0, 1, 2])
def test_distances_are_linear_in_what_is_sent(name, smooth, level):
    """A small move of what is new at a level changes distances as the columns, and `moved`, say."""
    fit, V0 = two_way(name, 2, smooth)
    at = fit.surface.build(V0, none(fit))
    samples = fit.measured(at.X[-1], 1e-4, 5_000)
    now = fit.surface.new_at(level)
    moves = 1e-6 * np.random.default_rng(0).normal(size=(now.stop - now.start, 3))
    moved = fit.moved(samples, level, moves)
    start, row, weight = fit.columns(samples, level)
    expected = samples.distance.copy()
    for j in range(len(moves)):
        k = row[start[j]:start[j + 1]]
        expected[k] += weight[start[j]:start[j + 1]] * (samples.away[k] @ moves[j])
    assert np.allclose(moved.distance, expected, atol=1e-11)


def test_the_model_says_what_will_be_measured():
    fit, V0 = two_way("closed", 2, 0)
    samples = fit.measured(fit.surface.build(V0, none(fit)).X[-1], 1e-4, 5_000)
    step = 1e-5 * np.random.default_rng(1).normal(size=V0.shape)
    after = fit.measured(fit.surface.build(V0 + step, none(fit)).X[-1], 1e-4, 5_000)
    said = fit.moved(samples, 0, step).distance / np.sqrt(samples.weight)
    measured = after.distance / np.sqrt(after.weight)
    before = samples.distance / np.sqrt(samples.weight)
    there = slice(0, np.count_nonzero(fit._rank < 5_000))  # of the surface: same points before and after
    assert np.abs(said - measured)[there].mean() < 0.1 * np.abs(measured - before)[there].mean()


def test_a_part_of_the_samples_is_of_both_ways():
    fit, V0 = two_way("closed")
    samples = fit.measured(fit.surface.build(V0, none(fit)).X[-1], 1e-4, 1_000)
    part = samples.part(100)
    assert len(samples.distance) == 2_000 and len(part.distance) == 200 and (part.rank < 100).all()
    assert samples.part(5_000) is samples
    assert np.count_nonzero(part.share[:, 2] == 0) >= 100  # middles of edges
