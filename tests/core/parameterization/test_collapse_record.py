import numpy as np
import pytest

from npm_blender.core.decimation import regions
from npm_blender.core.decimation.qem import decimate
from npm_blender.core.parameterization import collapse_record as module
from npm_blender.core.parameterization.collapse_record import (
    ALWAYS_FREE,
    AT,
    COLLAPSES,
    FACES,
    FIRST,
    POSITIONS,
    RING,
    SIDES,
    CollapseRecord,
)
from npm_blender.core.parameterization.stencil import MAX_RING, SPARE
from tests.meshes.lod_meshes import sheet, sphere, torus


@pytest.mark.parametrize("smallest", [500, regions.SMALLEST], ids=["regions", "whole"])
@pytest.mark.parametrize("shape", [lambda: sphere(5, noise=0.003), lambda: sheet(51, 61, noise=0.003)], ids=["sphere", "sheet"])
def test_how_much_room_is_made_changes_nothing(shape, smallest, monkeypatch):
    monkeypatch.setattr(regions, "SMALLEST", smallest)
    mesh = shape()
    one = decimate(mesh, 40)
    monkeypatch.setattr(module, "EACH", (0, 0, 0))
    two = decimate(mesh, 40)
    assert all(np.array_equal(a, b) for a, b in zip(one.record, two.record, strict=True))


def test_a_collapse_of_any_size_fits_in_what_is_always_left():
    assert ALWAYS_FREE > MAX_RING + SPARE
    record = CollapseRecord.empty().with_room(0)
    assert min(len(array) for array in record[:3]) >= ALWAYS_FREE


def test_faces_and_positions_follow_each_other_without_gaps():
    record = decimate(torus(40, 60), 60).record
    c = record.collapses
    assert (np.diff(c[:, FIRST]) == c[:-1, SIDES] + 2).all() and c[-1, FIRST] == len(record.faces)
    assert (np.diff(c[:-1, AT]) == c[:-2, RING] + 3).all()
    assert c[-2, AT] + c[-2, RING] + 3 == len(record.uv)


def test_what_is_filled_is_all_of_a_finished_record():
    record = decimate(sheet(21, 31), 60).record
    assert record.filled[COLLAPSES] == len(record.collapses) - 1
    assert record.filled[FACES] == len(record.faces) and record.filled[POSITIONS] == len(record.uv)


def test_records_that_follow_each_other_count_on():
    whole, parts = CollapseRecord.empty(), [decimate(sphere(2), 60).record, decimate(torus(12, 16), 60).record]
    joined = whole.followed_by(parts, 0).used()
    for name, start in (("faces", FIRST), ("uv", AT)):
        assert np.array_equal(getattr(joined, name), np.concatenate([getattr(part, name) for part in parts]))
        shift = len(getattr(parts[0], name))
        ends = [parts[0].collapses[:-1, start], parts[1].collapses[:-1, start] + shift]
        assert np.array_equal(joined.collapses[:-1, start], np.concatenate(ends))
    assert joined.filled.tolist() == (parts[0].filled + parts[1].filled).tolist() and not whole.filled.any()
