"""An opened stream: any prefix, any number of features, any level."""
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.codec import open_stream, progressive_mesh
from npm_blender.core.errors import SettingsError, StreamError
from tests.core.bitstream.samples import displaced_sample
from tests.core.codec.streams import known_latents

STREAMS = {"displaced": displaced_sample(levels=2, stages=3).data, "sharp": displaced_sample(smooth=0, seed=3).data,
           "latents": known_latents(60).data}
ALL = pytest.mark.parametrize("name", STREAMS)


@ALL
def test_every_prefix_decodes_as_the_whole_does_with_as_many_features(name):
    data = STREAMS[name]
    whole = open_stream(data)
    for cut in range(whole.base_bytes, len(data) + 1):
        part = open_stream(data[:cut])
        assert part.features >= whole.features_for(cut) and part.truncated == (cut < len(data))
        if cut % 7 == 0 or cut == len(data):
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
        assert len(mesh.F) == opened.faces_at(level) == opened.base_faces * 4**level and mesh.F.max() == len(mesh.V) - 1
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
    inner = opened._decoder.vertices
    monkeypatch.setattr(opened._decoder, "vertices", lambda *given: calls.append(given) or inner(*given))
    for k in (5, 6, 7, 5, 7, 8, 6):
        opened.decode_positions(k)
    assert [k for k, _ in calls] == [5, 6, 7, 8, 6]
