"""Ladders: more features are never farther off, flat parts end with the mesh itself, numbers that are asked for are obeyed."""
from functools import cache

import numpy as np
import pytest

from npm_blender.core.bitstream import read_stream
from npm_blender.core.codec import compress, displaced_sender, open_stream
from npm_blender.core.codec.displaced_sender import SAME, ladder, more_stages, one_rung
from npm_blender.core.codec.stages import Stages
from npm_blender.core.errors import Cancelled
from npm_blender.core.settings import AUTO, CompressSettings, LodSettings
from tests.core.codec.senders import free, target, target_of
from tests.core.codec.streams import SHAPES, cylinder, silent
from tests.core.codec.test_stages import errors_of
from tests.meshes.lod_meshes import gear
from tests.meshes.shapes import bumpy

PARTS = {"closed": bumpy(3), "a cylinder": cylinder(8), "a gear": gear(12)}
NAMES = pytest.mark.parametrize("name", PARTS)
FACES = 60


@cache
def climbed(name):
    """The ladder of a part whose first base is small, and its stream opened."""
    part = target_of(PARTS[name])
    before = {key: getattr(displaced_sender, key) for key in ("DEFAULT_FACES", "WHOLE", "LEAST_BYTES")}
    try:
        displaced_sender.DEFAULT_FACES, displaced_sender.WHOLE, displaced_sender.LEAST_BYTES = FACES, FACES + 20, 150
        found = ladder(part, AUTO, 4_000)
    finally:
        vars(displaced_sender).update(before)
    data, features = found.stream()
    return part, found, data, features


@pytest.mark.slow
@NAMES
def test_the_stream_holds_all_rungs_and_as_many_features_as_it_says(name):
    part, made, data, features = climbed(name)
    read, opened = read_stream(data, strict=True), open_stream(data)
    assert len(read.rungs) == len(made.rungs) and opened.features == opened.total_features == features
    assert opened.base_faces == FACES and not opened.truncated
    for one, stages in zip(read.rungs, made.rungs, strict=True):
        assert np.array_equal(one.grid, stages.base.grid) and np.array_equal(one.details.table, stages.table)
    sizes = [stages.base_size for stages in made.rungs]
    assert sizes == sorted(sizes)


@pytest.mark.slow
@NAMES
def test_more_features_are_never_farther_off_at_any_level(name):
    part, made, data, _ = climbed(name)
    errors = errors_of(open_stream(data), part.source)
    assert (errors[1:] <= 1.06 * np.minimum.accumulate(errors, 0)[:-1] + 1e-6).all()
    assert errors[-1, -1] < 0.5 * errors[0, 0]


@pytest.mark.slow
@NAMES
def test_each_rung_begins_no_farther_off_than_the_one_before_ends(name):
    _, made, _, _ = climbed(name)
    for below, above in zip(made.rungs, made.rungs[1:], strict=False):
        assert above.errors[0] <= SAME * below.errors[-1] * 1.05
        assert len(above.base.surface.F0) > len(below.base.surface.F0)


@pytest.mark.slow
def test_a_part_of_few_flat_faces_ends_with_the_mesh_itself():
    part, made, data, _ = climbed("a gear")
    last = made.rungs[-1].base
    assert len(made.rungs) > 1 and last.surface.levels == 0 and len(last.surface.F0) == len(PARTS["a gear"].F)
    decoded = open_stream(data).decode()
    assert len(decoded.F) == len(part.mesh.F) and last.error < 2.0**-last.bits
    assert len(read_stream(data).rungs[-1].details.table) == 0


def test_a_mesh_that_takes_more_than_there_is_does_not_come_itself(monkeypatch):
    size = displaced_sender._exact(target_of(PARTS["a gear"]), AUTO).base_size
    for most, comes in ((size, True), (size - 1, False)):
        monkeypatch.setattr(displaced_sender, "MOST_BYTES", most)
        assert (displaced_sender._exact(target_of(PARTS["a gear"]), AUTO) is not None) == comes


@pytest.mark.slow
@pytest.mark.parametrize("lod", [LodSettings(base_faces=40), LodSettings(levels=1), LodSettings(base_faces=40, levels=1)],
                         ids=["base faces", "levels", "both"])
def test_base_faces_or_levels_that_are_asked_for_make_one_rung(lod):
    read = read_stream(compress(SHAPES["torus"], CompressSettings(lod), silent).data, strict=True)
    assert read.finer is None and not read.header.followed
    assert lod.base_faces in (AUTO, len(read.F0)) and (lod.levels == AUTO or read.header.levels <= lod.levels)


@pytest.mark.slow
@pytest.mark.parametrize("name", SHAPES)
def test_no_level_of_a_rung_is_farther_off_than_a_coarser_one(name):
    made = one_rung(target(name), FACES, 2, AUTO, 2_000)
    (rung,), message = made.rungs, made.message
    assert message == "" and rung.base.surface.levels >= 1
    errors = rung.level_errors[:, : rung.base.surface.levels + 1]
    assert (errors[:, 1:] <= 1.05 * errors[:, :-1] + 1e-6).all()


def test_stages_end_where_there_are_bytes_enough():
    made = Stages(target("closed"), free("closed").rounded(0))
    most = made.base_size + 60
    more_stages(made, most)
    assert made.sizes()[-2] <= most and len(made.values) < len(more(most + 2_000).values)


def more(most):
    made = Stages(target("closed"), free("closed").rounded(0))
    more_stages(made, most)
    return made


def test_it_can_be_cancelled():
    def cancel(fraction, message):
        assert message
        if fraction > 0.1:
            raise Cancelled("Cancelled")

    with pytest.raises(Cancelled):
        ladder(target("closed"), AUTO, 2_000, cancel)
