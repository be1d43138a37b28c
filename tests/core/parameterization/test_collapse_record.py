import numpy as np
import pytest

from npm_blender.core.decimation import regions
from npm_blender.core.decimation.qem import decimate
from npm_blender.core.parameterization import collapse_record as module
from npm_blender.core.parameterization.collapse_record import AT, FIRST, RING, SIDES, SPARE, CollapseRecord
from npm_blender.core.parameterization.stencil import MAX_RING
from tests.meshes.lod_meshes import sheet, sphere, torus


@pytest.mark.parametrize("smallest", [500, regions.SMALLEST], ids=["regions", "whole"])
@pytest.mark.parametrize("shape", [lambda: sphere(5, noise=0.003), lambda: sheet(51, 61, noise=0.003)], ids=["sphere", "sheet"])
def test_how_much_room_is_made_changes_nothing(shape, smallest, monkeypatch):
    monkeypatch.setattr(regions, "SMALLEST", smallest)
    mesh = shape()
    one = decimate(mesh, 40)
    monkeypatch.setattr(module, "EACH", (0, 0, 0))
    two = decimate(mesh, 40)
    assert all(np.array_equal(a, b) for a, b in zip(one.history, two.history, strict=True))


def test_a_collapse_of_any_size_fits_in_what_is_always_left():
    assert SPARE > MAX_RING + 8
    history = CollapseRecord.empty().with_room(np.zeros(8, np.int64), 0)
    assert min(len(array) for array in history) >= SPARE


def test_faces_and_positions_follow_each_other_without_gaps():
    history = decimate(torus(40, 60), 60).history
    c = history.collapses
    assert (np.diff(c[:, FIRST]) == c[:-1, SIDES] + 2).all() and c[-1, FIRST] == len(history.faces)
    assert (np.diff(c[:-1, AT]) == c[:-2, RING] + 3).all()
    assert c[-2, AT] + c[-2, RING] + 3 == len(history.uv)
