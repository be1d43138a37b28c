"""Base vertices: a fit is nearer than the guess, and rounding with feedback nearer than rounding."""
import numpy as np
import pytest

from npm_blender.core.displacement import SMOOTHEST
from npm_blender.core.fitting import Rounding, fit_base
from npm_blender.core.fitting.base_fit import ROUNDINGS
from npm_blender.core.mesh import TriMesh
from tests.core.fitting.samples import SHAPES, none, two_way

ALL = [(name, smooth) for name in SHAPES for smooth in (0, SMOOTHEST)]


def error(fit, V0):
    X = fit.surface.build(V0, none(fit)).X[-1]
    return fit.source.error(TriMesh(X, fit.surface.hierarchy[-1].F), 6_000)


@pytest.mark.parametrize(("name", "smooth"), ALL)
def test_a_fitted_base_is_nearer_and_fitting_is_the_same_every_time(name, smooth):
    fit, V0 = two_way(name, 1, smooth)
    fitted = fit_base(fit, V0, none(fit), 3)
    assert error(fit, fitted) < 0.7 * error(fit, V0)
    again, _ = two_way(name, 1, smooth)
    assert np.array_equal(fit_base(again, V0, none(again), 3), fitted)


def test_no_passes_change_nothing():
    fit, V0 = two_way("closed")
    assert np.array_equal(fit_base(fit, V0, none(fit), 0), V0)


@pytest.mark.parametrize(("name", "smooth"), ALL)
def test_rounding_with_feedback_is_nearer_than_rounding(name, smooth):
    fit, V0 = two_way(name, 1, smooth)
    fitted, step = fit_base(fit, V0, none(fit), 3), 2.0**-5
    grid = Rounding(fit, fitted, none(fit)).on_lattice(step)
    assert grid.dtype == np.int64 and np.abs(grid * step - fitted).max() <= 5 * step
    assert error(fit, grid * step) < error(fit, np.rint(fitted / step) * step)


def test_a_fine_lattice_hardly_moves_anything():
    fit, V0 = two_way("closed", 1)
    grid = Rounding(fit, V0, none(fit)).on_lattice(2.0**-18)
    assert np.abs(grid * 2.0**-18 - V0).max() < (5 * ROUNDINGS + 1) * 2.0**-18
