"""Compress and open: the whole core on small meshes, without refinement (test_refine has that)."""
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.codec import compress, compression, open_stream, progressive_mesh
from npm_blender.core.errors import Cancelled, DependencyError, MeshError, SettingsError, StreamError
from npm_blender.core.evaluation.metrics import evaluate
from npm_blender.core.mesh.topology import topology_of
from npm_blender.core.mesh.triangle_mesh import TriMesh
from npm_blender.core.settings import CompressSettings, LodSettings
from tests.meshes.shapes import bumpy, grid, torus

SHAPES = {"closed": bumpy(4), "open": grid(40), "torus": torus(60, 30)}
FAST = CompressSettings(refine_steps=0, lod=LodSettings(base_faces=200))


@cache
def stream(name):
    return compress(SHAPES[name], FAST)


@pytest.mark.parametrize("name", SHAPES)
def test_decoded_mesh_is_near_the_source_and_keeps_its_topology(name):
    mesh, made = SHAPES[name], stream(name)
    opened = open_stream(made.data)
    decoded = opened.decode()
    source, now = topology_of(mesh.F), topology_of(decoded.F)
    assert (now.euler, now.border_loops, now.components) == (source.euler, source.border_loops, source.components)
    assert evaluate(decoded, mesh, 20_000).d_pm < evaluate(opened.decode(0, 0), mesh, 20_000).d_pm
    assert made.report.bytes == len(made.data) and made.report.features == opened.features == opened.total_features


@pytest.mark.parametrize("name", SHAPES)
def test_all_features_are_better_than_none(name):
    opened = open_stream(stream(name).data)
    few, many = (evaluate(opened.decode(k), SHAPES[name], 20_000).d_pm for k in (0, opened.features))
    assert many < few


@pytest.mark.parametrize("name", SHAPES)
def test_decoding_twice_is_identical_and_so_is_compressing(name):
    data = stream(name).data
    one, two = open_stream(data), open_stream(data)
    assert (one.decode_positions() == two.decode_positions()).all()
    one.decode(5), one.decode(0)
    assert (one.decode_positions() == two.decode_positions()).all()
    assert compress(SHAPES[name], FAST).data == data


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(st.floats(0, 1))
def test_every_prefix_past_the_base_decodes_as_the_whole_does(share):
    data = stream("closed").data
    whole = open_stream(data)
    cut = round(whole.base_bytes + share * (len(data) - whole.base_bytes))
    arrived = open_stream(data[:cut])
    assert arrived.features == whole.features_for(cut)
    assert (arrived.decode_positions() == whole.decode_positions(arrived.features)).all()
    assert arrived.truncated == (arrived.features < whole.features)


def test_a_prefix_that_ends_before_the_base_is_refused():
    data = stream("closed").data
    with pytest.raises(StreamError):
        open_stream(data[:open_stream(data).base_bytes - 1])


def test_bytes_and_features_answer_each_other():
    opened = open_stream(stream("closed").data)
    for k in (0, 1, 40, 100, opened.features):
        size = opened.bytes_for(k)
        assert opened.features_for(size) >= k
        if k:
            assert opened.features_for(size - 1) < k
    assert opened.bytes_for(opened.features) == opened.total_bytes
    with pytest.raises(SettingsError, match="base mesh"):
        opened.features_for(opened.base_bytes - 1)


def test_levels_do_not_depend_on_what_was_decoded_before():
    opened = open_stream(stream("closed").data)
    opened.decode(100)
    for level in range(opened.levels + 1):
        mesh = opened.decode(100, level)
        assert len(mesh.F) == opened.faces_at(level) == opened.base_faces * 4**level
        assert (mesh.V == open_stream(stream("closed").data).decode(100, level).V).all()


def test_stops_in_any_order_decode_as_a_fresh_stream_does():
    opened = open_stream(stream("torus").data)
    rng = np.random.default_rng(5)
    for k in [*rng.integers(0, opened.features + 1, 6), *range(opened.features - 3, opened.features), 41, 0]:
        level = int(rng.integers(1, opened.levels + 1))
        assert np.array_equal(opened.decode(int(k), level).V, open_stream(stream("torus").data).decode(int(k), level).V)


def test_only_steps_that_see_a_change_are_done_again(monkeypatch):
    opened = open_stream(stream("torus").data)
    groups = opened._group
    finest = int(np.flatnonzero((groups >= opened.levels) & (groups % opened.levels == opened.levels - 1))[-1])
    done = []
    predict = progressive_mesh.predict
    monkeypatch.setattr(progressive_mesh, "predict", lambda *given: done.append(given[2]) or predict(*given))
    before = opened.decode(finest)
    assert done == list(range(opened.levels))
    after = opened.decode(finest + 1)
    assert done == list(range(opened.levels)) and (before.V != after.V).any()
    opened.decode(0)
    assert done == 2 * list(range(opened.levels))


@pytest.mark.parametrize("levels", [1, 2, 4])
def test_other_numbers_of_levels(levels):
    made = compress(SHAPES["closed"], CompressSettings(refine_steps=0, lod=LodSettings(base_faces=100, levels=levels)))
    opened = open_stream(made.data)
    assert opened.levels == levels and len(opened.decode().F) == 100 * 4**levels
    assert evaluate(opened.decode(), SHAPES["closed"], 20_000).d_pm < 150


@pytest.mark.parametrize("bad", [-1, 4])
def test_levels_and_features_out_of_range(bad):
    opened = open_stream(stream("closed").data)
    with pytest.raises(SettingsError, match="level from 0 to 3"):
        opened.decode(0, bad)
    with pytest.raises(SettingsError, match="features"):
        opened.decode(bad if bad < 0 else opened.features + 1)


def test_object_space_is_kept():
    mesh = SHAPES["closed"]
    moved = TriMesh(mesh.V * 250 + [1e4, -30, 7], mesh.F)
    a = open_stream(compress(moved, FAST).data).decode()
    b = open_stream(stream("closed").data).decode()
    assert np.abs((a.V - [1e4, -30, 7]) / 250 - b.V).max() < 0.02


def test_magnitude_order_sends_the_largest_latents_first_and_gain_order_those_that_save_most():
    by_magnitude = open_stream(compress(SHAPES["closed"], CompressSettings(
        refine_steps=0, order="magnitude", lod=FAST.lod)).data)
    by_gain = open_stream(stream("closed").data)
    errors = [evaluate(p.decode(40), SHAPES["closed"], 20_000).d_pm for p in (by_gain, by_magnitude)]
    assert errors[0] <= errors[1]
    whole = [evaluate(p.decode(), SHAPES["closed"], 20_000).d_pm for p in (by_gain, by_magnitude)]
    assert abs(whole[0] / whole[1] - 1) < 0.1


def test_cancelling_from_progress_ends_the_work():
    def progress(fraction, message):
        assert 0 <= fraction <= 1 and message
        if fraction > 0.3:
            raise Cancelled("Cancelled by the user")

    with pytest.raises(Cancelled):
        compress(SHAPES["closed"], FAST, progress)


def test_progress_grows():
    seen = []
    compress(SHAPES["closed"], FAST, lambda fraction, message: seen.append(fraction))
    assert all(a <= b + 1e-9 for a, b in zip(seen, seen[1:], strict=False)) and seen[-1] <= 1


def test_refinement_without_torch_is_refused_only_when_asked_for(monkeypatch):
    monkeypatch.setattr(compression, "has_torch", lambda: False)
    with pytest.raises(DependencyError, match="install torch or use 0"):
        compress(SHAPES["closed"], CompressSettings(refine_steps=5))
    assert "refine" not in compress(SHAPES["closed"], CompressSettings(lod=FAST.lod)).report.seconds


BAD = {
    "one triangle": (np.eye(3), [[0, 1, 2]], "faces"),
    "no faces": (np.eye(3), np.zeros((0, 3), int), "found none"),
    "nan": (np.full((3, 3), np.nan), [[0, 1, 2]], "NaN"),
    "index": (np.eye(3), [[0, 1, 7]], "indices"),
    "quads": (np.zeros((4, 3)), [[0, 1, 2, 3]], "triangulate"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_meshes_by_name(name):
    V, F, message = BAD[name]
    with pytest.raises(MeshError, match=message):
        compress(TriMesh.from_arrays(np.asarray(V, float), np.asarray(F)), FAST)


def test_settings_out_of_range():
    for make in (lambda: LodSettings(base_faces=2), lambda: LodSettings(levels=7), lambda: LodSettings(clean="maybe"),
                 lambda: CompressSettings(position_bits=8), lambda: CompressSettings(order="random"),
                 lambda: LodSettings(levels=True), lambda: CompressSettings(refine_steps=-1)):
        with pytest.raises(SettingsError, match="Expected"):
            make()
