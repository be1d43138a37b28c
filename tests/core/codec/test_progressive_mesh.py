"""An opened stream: any prefix, any number of features, any level."""
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.codec import open_stream, progressive_mesh
from npm_blender.core.errors import SettingsError, StreamError
from tests.core.bitstream.samples import creased_sample, displaced_sample, ladder_of, ladder_sample
from tests.core.codec.streams import known_latents

STREAMS = {"displaced": displaced_sample(levels=2, stages=3).data, "sharp": displaced_sample(smooth=0, seed=3).data,
           "creased": creased_sample(levels=1, stages=2).data, "ladder": ladder_sample().data,
           "latents": known_latents(60).data}
ALL = pytest.mark.parametrize("name", STREAMS)


@pytest.mark.slow
@ALL
def test_every_prefix_decodes_as_the_whole_does_with_as_many_features(name):
    data = STREAMS[name]
    whole = open_stream(data)
    for cut in range(whole.base_bytes, len(data) + 1):
        part = open_stream(data[:cut])
        assert part.features >= whole.features_for(cut) and part.truncated == (cut < len(data))
        if cut % 11 == 0 or cut == len(data):
            for level in range(whole.levels + 1):
                assert np.array_equal(part.decode_positions(level=level), whole.decode_positions(part.features, level))


@ALL
def test_a_prefix_that_ends_before_the_base_is_refused(name):
    with pytest.raises(StreamError, match="get the rest"):
        open_stream(STREAMS[name][:open_stream(STREAMS[name]).base_bytes - 1])


@ALL
def test_bytes_and_features_answer_each_other(name):
    opened = open_stream(STREAMS[name])
    for k in {0, 1, 20, 33, opened.features // 2, opened.features}:
        size = opened.bytes_for(k)
        assert opened.features_for(size) >= k and open_stream(STREAMS[name][:size]).features >= k
        if k:
            assert opened.features_for(size - 1) < k
    assert opened.bytes_for(0) == opened.base_bytes and opened.bytes_for(opened.features) == opened.total_bytes
    with pytest.raises(SettingsError, match="base mesh"):
        opened.features_for(opened.base_bytes - 1)


@ALL
def test_levels_do_not_depend_on_what_was_decoded_before(name):
    opened, rng = open_stream(STREAMS[name]), np.random.default_rng(5)
    for _ in range(12):
        k, level = int(rng.integers(0, opened.features + 1)), int(rng.integers(0, opened.levels + 1))
        mesh = opened.decode(k, level)
        assert len(mesh.F) == opened.faces_at(level, k) and mesh.F.max() == len(mesh.V) - 1
        assert opened.rung_at(k) or len(mesh.F) == opened.base_faces * 4**min(level, opened.header.levels)
        assert np.array_equal(mesh.V, open_stream(STREAMS[name]).decode_positions(k, level))


@ALL
def test_stops_rise_from_none_to_all(name):
    opened = open_stream(STREAMS[name])
    assert opened.stops[0] == 0 and opened.stops[-1] == opened.features and list(opened.stops) == sorted(set(opened.stops))


@ALL
@settings(max_examples=40)
@given(data=st.data())
def test_what_is_damaged_decodes_or_is_refused(name, data):
    bad = bytearray(STREAMS[name][:data.draw(st.integers(1, len(STREAMS[name])))])
    bad[data.draw(st.integers(0, len(bad) - 1))] ^= data.draw(st.integers(1, 255))
    try:
        opened = open_stream(bytes(bad))
    except StreamError:
        return
    assert np.isfinite(opened.decode_positions()).all()
    assert opened.shortfall if opened.corrupt or opened.truncated else not opened.shortfall


@ALL
def test_out_of_range_is_refused(name):
    opened = open_stream(STREAMS[name])
    for bad in (-1, opened.levels + 1):
        with pytest.raises(SettingsError, match=f"level from 0 to {opened.levels}"):
            opened.decode(0, bad)
    for bad in (-1, opened.features + 1):
        with pytest.raises(SettingsError, match="features"):
            opened.decode(bad)


def test_the_last_decodes_are_kept(monkeypatch):
    opened, calls = open_stream(STREAMS["displaced"]), []
    monkeypatch.setattr(progressive_mesh, "CACHED", 3)
    inner = opened._rungs[0].vertices
    monkeypatch.setattr(opened._rungs[0], "vertices", lambda *given: calls.append(given) or inner(*given))
    for k in (5, 6, 7, 5, 7, 8, 6):
        opened.decode_positions(k)
    assert [k for k, _ in calls] == [5, 6, 7, 8, 6]


LADDER = ladder_sample()
OPENED = open_stream(LADDER.data)
BASES = [0, *(3 * len(sample.grid) for sample in LADDER.rungs[1:])]  # features that the bases count for
NUMBERS = [sample.header.total_features for sample in LADDER.rungs]
FROM = [sum(NUMBERS[:k]) + sum(BASES[: k + 1]) for k in range(3)]  # features from which each rung is there


def test_features_of_a_ladder_are_numbers_and_coordinates_of_later_bases():
    assert OPENED.features == OPENED.total_features == sum(NUMBERS) + sum(BASES)
    assert OPENED.base_faces == len(LADDER.rungs[0].base.F0) and OPENED.base_vertices == len(LADDER.rungs[0].grid)
    assert OPENED.levels == max(sample.header.levels for sample in LADDER.rungs) and not OPENED.shortfall
    assert set(FROM) <= set(OPENED.stops)


def test_the_last_rung_whose_base_is_there_is_shown():
    for place, first in enumerate(FROM):
        assert OPENED.rung_at(first) == place and (not place or OPENED.rung_at(first - 1) == place - 1)
        assert len(OPENED.level_faces(0, first)) == len(LADDER.rungs[place].base.F0)
        alone = open_stream(ladder_of(LADDER.rungs[place]).data)
        for level in range(OPENED.levels + 1):
            k = min(level, alone.levels)
            assert np.array_equal(OPENED.decode_positions(first, level), alone.decode_positions(0, k))
            last = first + NUMBERS[place]
            assert np.array_equal(OPENED.decode_positions(last, level), alone.decode_positions(alone.features, k))
            assert np.array_equal(OPENED.level_faces(level, last), alone.level_faces(k))


def test_half_a_base_shows_the_whole_of_the_rung_before():
    for place in (1, 2):
        whole = FROM[place] - BASES[place]
        for k in (whole + 1, FROM[place] - 1):
            assert np.array_equal(OPENED.decode_positions(k), OPENED.decode_positions(whole))
            assert OPENED.bytes_for(k) == OPENED.bytes_for(FROM[place]) > OPENED.bytes_for(whole)


def test_levels_above_the_finest_of_a_rung_show_its_finest():
    last = OPENED.features
    assert LADDER.rungs[-1].header.levels < OPENED.levels
    for level in range(OPENED.levels + 1):
        assert np.array_equal(OPENED.decode_positions(last, level), OPENED.decode_positions(last, 0))
        assert OPENED.faces_at(level, last) == OPENED.faces_at(level) == len(LADDER.rungs[-1].base.F0)


def test_faces_fit_vertices_at_every_stop_and_level():
    for k in OPENED.stops:
        for level in range(OPENED.levels + 1):
            F, V = OPENED.level_faces(level, k), OPENED.decode_positions(k, level)
            assert F.max() == len(V) - 1 and np.isfinite(V).all() and len(F) == OPENED.faces_at(level, k)


def test_every_number_of_bytes_of_a_ladder_has_its_features():
    before = 0
    for size in range(OPENED.base_bytes, OPENED.total_bytes + 1):
        k = OPENED.features_for(size)
        assert k >= before and OPENED.bytes_for(k) <= size
        before = k
    for k in range(OPENED.features + 1):
        assert OPENED.features_for(OPENED.bytes_for(k)) >= k and (not k or OPENED.bytes_for(k - 1) <= OPENED.bytes_for(k))


def test_a_ladder_that_is_damaged_in_a_later_base_is_shown_up_to_it_and_says_so():
    first = OPENED.bytes_for(NUMBERS[0])
    bad = bytearray(LADDER.data)
    bad[first + 30] ^= 1
    found = open_stream(bad)
    assert found.features == NUMBERS[0] and found.total_features == OPENED.total_features
    assert f"is damaged after {first:,} of" in found.shortfall and np.isfinite(found.decode_positions()).all()
