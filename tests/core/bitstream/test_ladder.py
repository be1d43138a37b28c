"""Streams of several rungs: all come back, any prefix shows the last that is there, damage leaves those before it."""
from binascii import crc_hqx
from dataclasses import replace
from zlib import crc32

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.bitstream import (
    BASE_NUMBERS,
    DisplacedCoding,
    Header,
    Rung,
    encode_base,
    read_stream,
    write_ladder,
)
from npm_blender.core.bitstream.chunks import CRC_BYTES, chunk_ends
from npm_blender.core.bitstream.header import MAX_RUNGS
from npm_blender.core.bitstream.heads import read_head
from npm_blender.core.errors import StreamError
from npm_blender.core.mesh import hierarchy
from tests.core.bitstream.samples import base_level, creased_sample, displaced_sample, ladder_of, ladder_sample
from tests.core.bitstream.test_displacements import first_numbers

LADDERS = {"three": ladder_sample(),
           "no numbers below": ladder_of(displaced_sample(levels=0, stages=0), creased_sample(seed=2, levels=1, stages=2)),
           "nothing but zeros below": ladder_of(displaced_sample(levels=0, table=np.zeros((2, base_level().n), np.int64)),
                                                creased_sample(seed=3, levels=0, stages=1))}
READ = {name: read_stream(ladder.data) for name, ladder in LADDERS.items()}
NAMES = pytest.mark.parametrize("name", LADDERS)


def same_base(found, sample):
    """A rung has this base."""
    assert np.array_equal(found.grid, sample.grid) and np.array_equal(found.F0, sample.base.F0)
    assert (found.sharp is None) == (sample.sharp is None)
    if sample.sharp:
        assert np.array_equal(found.sharp.edges, sample.sharp.edges)
        assert np.array_equal(found.sharp.corners, sample.sharp.corners)


def same_beginning(found, name):
    """Each rung of what was read is the beginning of that of the whole; the last alone may lack numbers."""
    rungs = found.rungs
    for place, (one, whole, sample) in enumerate(zip(rungs, READ[name].rungs, LADDERS[name].rungs, strict=False)):
        same_base(one, sample)
        assert one.header == whole.header and one.base_bytes == whole.base_bytes
        assert one.features == whole.features or place == len(rungs) - 1
        levels = hierarchy(one.F0, len(one.grid), one.header.levels)
        first = np.array([0, *(level.n for level in levels)])
        expected = first_numbers(sample.features, whole.details.coded, first, one.features)
        assert np.array_equal(one.details.table, expected)


def count(found):
    """Features that arrived, those of later bases with them."""
    return sum(one.features for one in found.rungs) + sum(BASE_NUMBERS * len(one.grid) for one in found.rungs[1:])


def behind(one):
    """The offset behind the last checksum of a rung."""
    return one.base_bytes + one.header.coding.payload + CRC_BYTES * len(chunk_ends(one.header.coding.payload))


@NAMES
def test_all_rungs_come_back(name):
    read, ladder = READ[name], LADDERS[name]
    same_beginning(read, name)
    assert len(read.rungs) == len(ladder.rungs)
    for one, sample in zip(read.rungs, ladder.rungs, strict=True):
        assert one.features == sample.header.total_features and not one.truncated and one.corrupt is None
        assert np.array_equal(one.details.table, sample.features)
        said = replace(one.header, total_features=0, followed=False)
        assert said == replace(sample.header, total_features=0) and one.header.followed == (one.finer is not None)


@NAMES
def test_features_are_all_that_follow(name):
    read = READ[name]
    assert read.header.total_features == count(read)
    for one in read.rungs[:-1]:
        assert one.header.total_features - one.finer.header.total_features == \
            one.features + (0 if one is read else BASE_NUMBERS * len(one.grid))


@NAMES
def test_bytes_rise_from_rung_to_rung(name):
    ends = np.concatenate([one.ends[1] for one in READ[name].rungs])
    assert (np.diff(ends) >= 0).all() and behind(READ[name].rungs[-1]) == len(LADDERS[name].data)
    for one in READ[name].rungs:
        assert one.ends[0][0] == 0 and one.ends[1][0] == one.base_bytes and (np.diff(one.ends[0]) > 0).all()
        assert one.finer is None or behind(one) < one.finer.base_bytes
        assert one.ends[1][-1] == (behind(one) if one.features else one.base_bytes)


def test_one_rung_is_a_stream_without_more():
    sample = displaced_sample()
    assert write_ladder([sample.rung]) == sample.data and read_stream(sample.data).finer is None


def test_the_first_rung_of_a_ladder_differs_from_that_alone_in_its_head_only():
    alone, ladder = displaced_sample(levels=1, stages=2), LADDERS["three"]
    one, many = (read_stream(data) for data in (alone.data, ladder.data))
    assert replace(many.header, followed=False, total_features=0) == replace(one.header, total_features=0)
    body = alone.base.connectivity + alone.base.positions
    assert ladder.data[many.base_bytes - 4 - len(body):many.base_bytes - 4] == body


@NAMES
def test_every_prefix_past_the_first_base_opens_and_holds_what_the_whole_says(name):
    whole, data = READ[name], LADDERS[name].data
    before, bases = -1, [one.base_bytes for one in whole.rungs]
    for cut in range(whole.base_bytes, len(data), 2):
        read = read_stream(data[:cut])
        assert len(read.rungs) == sum(base <= cut for base in bases)
        assert read.rungs[-1].truncated and not any(one.truncated for one in read.rungs[:-1])
        assert not any(one.corrupt for one in read.rungs)
        same_beginning(read, name)
        last = whole.rungs[len(read.rungs) - 1]
        assert read.rungs[-1].features >= last.ends[0][np.searchsorted(last.ends[1], cut, "right") - 1]
        assert count(read) >= before
        before = count(read)


@NAMES
def test_a_cut_inside_a_later_base_shows_the_rung_before(name):
    data = LADDERS[name].data
    for one in READ[name].rungs[:-1]:
        for cut in range(behind(one), one.finer.base_bytes, 3):
            read = read_stream(data[:cut]).rungs[-1]
            assert (read.truncated, read.corrupt, read.finer) == (True, None, None) and read.header == one.header
            assert read.features == one.features


@pytest.mark.slow
@NAMES
def test_every_flipped_byte_is_noticed_and_leaves_what_came_before(name):
    data, whole = LADDERS[name].data, READ[name]
    starts = [one.base_bytes for one in whole.rungs]
    for at in range(whole.base_bytes, len(data)):
        read = read_stream(data[:at] + bytes([data[at] ^ (1 << at % 8)]) + data[at + 1:])
        same_beginning(read, name)
        last = read.rungs[-1]
        assert last.corrupt or last.truncated
        assert not last.corrupt or "Expected" in last.corrupt and "\n" not in last.corrupt
        assert len(read.rungs) == sum(start <= at for start in starts)


@NAMES
def test_a_damaged_later_base_keeps_the_rungs_before_it(name):
    data = LADDERS[name].data
    for one in READ[name].rungs[:-1]:
        start = behind(one)
        before = int.from_bytes(data[one.base_bytes - 4:one.base_bytes], "big")
        body = read_head(data, start, READ[name].header, before).end
        for place, words in ((body, "intact base mesh"), (one.finer.base_bytes - 1, "intact base mesh"),
                             (start + 1, "intact header"), (body - 1, "intact header")):
            bad = bytearray(data)
            bad[place] ^= 4
            read = read_stream(bad).rungs[-1]
            assert words in read.corrupt and read.features == one.features and read.finer is None and not read.truncated
            with pytest.raises(StreamError, match=words):
                read_stream(bad, strict=True)


@NAMES
def test_strict_reading_raises_what_any_rung_reports(name):
    data = bytearray(LADDERS[name].data)
    data[-1] ^= 1
    assert read_stream(data).rungs[-1].corrupt
    with pytest.raises(StreamError, match="wrong checksum"):
        read_stream(data, strict=True)


@NAMES
def test_what_follows_the_last_rung_is_named(name):
    read = read_stream(LADDERS[name].data + b"\0\0")
    assert "2 bytes more" in read.rungs[-1].corrupt and not read.rungs[0].corrupt and count(read) == count(READ[name])
    same_beginning(read, name)


def small_rungs(number):
    """So many rungs of one quad each."""
    F0, at = np.array([[0, 1, 2], [3, 1, 0]]), np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    header = Header(0, 8, 0, 2, 4, (0, 0, 0), 1.0, DisplacedCoding(0, 0, 22, 0, 0))
    return [Rung(header, encode_base((9 + k) * at, F0), b"") for k in range(number)]


def test_as_many_rungs_as_may_be_open_and_one_more_is_refused():
    most = read_stream(write_ladder(small_rungs(MAX_RUNGS)), strict=True)
    assert len(most.rungs) == MAX_RUNGS and [one.grid[3, 0] for one in most.rungs] == list(range(9, 9 + MAX_RUNGS))
    data = write_ladder(small_rungs(MAX_RUNGS + 1))
    more = read_stream(data)
    assert len(more.rungs) == MAX_RUNGS and f"at most {MAX_RUNGS} rungs" in more.rungs[-1].corrupt
    with pytest.raises(StreamError, match=f"at most {MAX_RUNGS} rungs"):
        read_stream(data, strict=True)


@pytest.mark.parametrize("place", [0, 1, 2])
def test_a_promise_that_a_rung_does_not_keep_is_reported(place):
    rungs = [sample.rung for sample in LADDERS["three"].rungs]
    header = rungs[place].header
    rungs[place] = rungs[place]._replace(header=replace(header, total_features=header.total_features + 1))
    read = read_stream(write_ladder(rungs))
    found = [one.corrupt for one in read.rungs]
    assert found[place] == f"Expected {header.total_features + 1} numbers, found {header.total_features}"
    assert [wrong for wrong in found if wrong] == [found[place]] and len(read.rungs) == 3


def test_a_promise_of_another_rung_that_does_not_come_is_a_cut():
    whole = LADDERS["three"].data
    read = read_stream(whole[:behind(READ["three"])])
    assert read.truncated and read.header.followed and read.finer is None and read.features == READ["three"].features


def mended(data, name, at, value):
    """The stream with another byte, and checksums of all rungs that say that it is right."""
    body, first, start, was, now = bytearray(data), None, 0, 0, 0
    body[at] = value
    for one in READ[name].rungs:
        head = read_head(data, start, first, was)
        was = int.from_bytes(data[one.base_bytes - 4:one.base_bytes], "big")
        body[head.end - 2:head.end] = (crc32(body[start:head.end - 2], now) & 0xFFFF).to_bytes(2, "big")
        now = crc32(body[start:one.base_bytes - 4], now)
        body[one.base_bytes - 4:one.base_bytes] = now.to_bytes(4, "big")
        crc, start = int.from_bytes(body[one.base_bytes - 2:one.base_bytes], "big"), one.base_bytes
        for size in np.diff([0, *chunk_ends(one.header.coding.payload)]).tolist():
            crc = crc_hqx(body[start:start + size], crc)
            body[start + size:start + size + CRC_BYTES] = crc.to_bytes(2, "big")
            start += size + CRC_BYTES
        first = first or head.header
    return bytes(body)


@NAMES
def test_nothing_but_a_mended_byte_is_changed(name):
    data = LADDERS[name].data
    assert mended(data, name, 4, data[4]) == data


@NAMES
@settings(max_examples=80)
@given(data=st.data())
def test_damage_with_mended_checksums_is_refused_or_decodes(name, data):
    whole = LADDERS[name].data
    at = data.draw(st.integers(4, len(whole) - 1))
    try:
        read = read_stream(mended(whole, name, at, data.draw(st.integers(0, 255))))
    except StreamError as error:
        assert "Expected" in str(error) and "\n" not in str(error)
    else:
        for one in read.rungs:
            assert one.F0.min() >= 0 and one.F0.max() < len(one.grid) and one.features >= 0


@NAMES
@settings(max_examples=60)
@given(data=st.data())
def test_any_damage_and_cut_ends_in_an_error_or_rungs(name, data):
    whole = LADDERS[name].data
    damaged = bytearray(whole[:data.draw(st.integers(1, len(whole)))])
    for _ in range(data.draw(st.integers(0, 3))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] ^= data.draw(st.integers(1, 255))
    try:
        read = read_stream(bytes(damaged))
    except StreamError as error:
        assert "Expected" in str(error)
    else:
        assert 1 <= len(read.rungs) <= len(READ[name].rungs)
        assert all(a.features <= b.features + 32 for a, b in zip(read.rungs, READ[name].rungs, strict=False))
