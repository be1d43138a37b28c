"""Vertices of a displaced surface are what the numbers say, however many have arrived."""
from dataclasses import replace

import numpy as np
import pytest

from npm_blender.core.bitstream import read_stream
from npm_blender.core.codec.displaced_decoder import DisplacedDecoder
from npm_blender.core.displacement import DisplacedSurface
from tests.core.bitstream.samples import creased_sample, displaced_sample
from tests.core.bitstream.test_displacements import first_numbers

LEVELS, STAGES = 2, 3
SAMPLE = displaced_sample(LEVELS, STAGES)
READ = read_stream(SAMPLE.data)


def decoder(ends=None):
    """Of the sample, with other `ends`."""
    coding = replace(READ.header.coding, ends=ends) if ends else READ.header.coding
    return DisplacedDecoder(replace(READ, header=replace(READ.header, coding=coding)))


def expected(count, level):
    """Vertices that the first `count` numbers make: each number times the step of its stage, or of the stage before."""
    surface = DisplacedSurface(READ.F0, len(READ.grid), LEVELS, READ.header.coding.smooth)
    first = surface.first
    table = first_numbers(SAMPLE.features, READ.details.coded, first, count)
    last = READ.header.coding.steps(LEVELS, STAGES - 1)
    return surface.shown(READ.V0, table[-1] * np.repeat(last, np.diff(first)), level)


@pytest.mark.parametrize("level", range(LEVELS + 1))
def test_vertices_are_what_the_numbers_say(level):
    whole = decoder((STAGES,) * LEVELS)
    for count in [*range(0, READ.features, 13), READ.features]:
        assert np.allclose(whole.vertices(count, level), expected(count, level), atol=1e-14)


@pytest.mark.parametrize("end", range(STAGES + 1))
def test_a_level_stays_as_it_is_after_its_last_stage(end):
    whole, held = decoder((STAGES,) * LEVELS), decoder((end,) * LEVELS)
    new = np.diff([0, *(level.n for level in whole.levels)])
    last = int((READ.details.coded[:end] * new).sum())
    for count in range(0, READ.features, 29):
        for level in range(LEVELS):
            assert np.array_equal(held.vertices(count, level), whole.vertices(min(count, last), level))
        assert np.array_equal(held.vertices(count, LEVELS), whole.vertices(count, LEVELS))


def test_stops_are_the_ends_of_stages():
    new = np.diff([0, *(level.n for level in decoder().levels)])
    sizes = (READ.details.coded * new).sum(1)
    assert decoder().stops == tuple(np.cumsum(sizes)[sizes > 0].tolist())
    assert decoder().scalars(7) == 7


def test_a_base_alone_decodes():
    bare = displaced_sample(levels=0, stages=0, table=np.zeros((0, len(SAMPLE.grid)), np.int64))
    read = read_stream(bare.data)
    assert np.array_equal(DisplacedDecoder(read).vertices(0, 0), read.V0) and DisplacedDecoder(read).stops == ()


def test_creases_of_the_base_stay_sharp_at_every_level():
    sample = creased_sample(levels=2, stages=1, seed=4)
    read = read_stream(sample.data)
    surface = DisplacedSurface(read.F0, len(read.grid), 2, 8, sample.sharp)
    moves = sample.features[0] * np.repeat(read.header.coding.steps(2, 0), np.diff(surface.first))
    found, without = DisplacedDecoder(read), DisplacedDecoder(replace(read, sharp=None))
    assert np.array_equal(found.vertices(read.features, 2), surface.shown(read.V0, moves, 2))
    assert not np.allclose(found.vertices(0, 2), without.vertices(0, 2), atol=1e-3)
