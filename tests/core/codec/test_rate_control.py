"""A budget in bytes: it is kept, it is used, and more of it shows more."""
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npm_blender.core.codec import compress, open_stream, rate_control
from npm_blender.core.errors import SettingsError
from npm_blender.core.evaluation.metrics import evaluate
from npm_blender.core.settings import AUTO, CompressSettings, LodSettings
from tests.meshes.dirty_meshes import many_parts
from tests.meshes.shapes import bumpy, grid, torus

SHAPES = {"closed": bumpy(5), "open": grid(60), "torus": torus(90, 40)}
CHOSEN = LodSettings(base_faces=AUTO, levels=AUTO)
BUDGETS = (500, 1_000, 2_500)


def limited(size, lod=CHOSEN):
    return CompressSettings(lod=lod, refine_steps=0, budget=size)


@cache
def made(name, size):
    return compress(SHAPES[name], limited(size))


@pytest.mark.slow
@pytest.mark.parametrize("size", BUDGETS)
@pytest.mark.parametrize("name", SHAPES)
def test_the_file_is_whole_and_fills_the_budget(name, size):
    done = made(name, size)
    opened = open_stream(done.data)
    assert len(done.data) <= size and not opened.truncated
    assert opened.features == opened.total_features == done.report.features
    assert len(done.data) > 0.9 * size and (done.report.features < 300 or len(done.data) > 0.97 * size)


@pytest.mark.slow
@pytest.mark.parametrize("name", SHAPES)
def test_more_bytes_show_more(name):
    errors = [evaluate(open_stream(made(name, size).data).decode(), SHAPES[name], 20_000).d_pm for size in BUDGETS]
    assert errors == sorted(errors, reverse=True) and errors[0] > 2 * errors[-1]


def test_no_further_feature_would_fit():
    whole = compress(SHAPES["closed"], CompressSettings(lod=LodSettings(base_faces=100, levels=2), refine_steps=0))
    opened = open_stream(whole.data)
    middle = (opened.base_bytes + len(whole.data)) // 2
    cut = compress(SHAPES["closed"], limited(middle, LodSettings(base_faces=100, levels=2)))
    next_packet = opened.bytes_for(opened.features_for(middle) + 1)
    assert opened.features_for(middle) <= cut.report.features < opened.features
    assert len(cut.data) <= middle < next_packet
    assert middle - len(cut.data) < 40  # a feature of eight numbers


def test_a_budget_that_everything_fits_into_changes_nothing():
    lod = LodSettings(base_faces=100, levels=1)
    whole = compress(SHAPES["closed"], CompressSettings(lod=lod, refine_steps=0))
    assert compress(SHAPES["closed"], limited(len(whole.data), lod)).data == whole.data
    assert compress(SHAPES["closed"], limited(10**9, lod)).data == whole.data


def test_a_base_that_was_asked_for_and_does_not_fit_is_refused():
    with pytest.raises(SettingsError, match=r"Expected a base mesh of at most 500 bytes, found .* for 400 faces; allow more"):
        compress(SHAPES["closed"], limited(500, LodSettings(base_faces=400)))


@pytest.mark.slow
def test_a_mesh_of_many_parts_is_given_fewer_faces_or_refused():
    parts = many_parts(12)
    done = compress(parts, limited(900))
    assert len(done.data) <= 900
    with pytest.raises(SettingsError, match="allow more bytes"):
        compress(many_parts(60), limited(300))


@pytest.mark.slow
def test_files_of_hardly_more_than_the_base_keep_to_their_size_or_are_refused():
    lod, made_it = LodSettings(base_faces=200, levels=3), []
    base = open_stream(compress(SHAPES["torus"], CompressSettings(lod=lod, refine_steps=0)).data).base_bytes
    for size in (base - 40, base - 10, base - 1, base, base + 1, base + 10, base + 24):
        try:
            assert len(compress(SHAPES["torus"], limited(size, lod)).data) <= size
            made_it.append(True)
        except SettingsError as error:
            assert "allow more bytes" in str(error)
            made_it.append(False)
    assert made_it == sorted(made_it) and not made_it[0] and made_it[-1]


def test_impossible_budgets_are_refused():
    for size in (-1, 1, 299, 10**10, True, 1000.0):
        with pytest.raises(SettingsError, match="Expected budget in bytes"):
            CompressSettings(budget=size)


@given(st.integers(300, 10**7), st.integers(0, 10**5))
def test_more_bytes_never_mean_fewer_base_faces(size, more):
    small, large = rate_control.base_faces_for(size), rate_control.base_faces_for(size + more)
    assert rate_control.FEWEST <= small <= large <= rate_control.MOST
    assert 1.5 * small < size or small == rate_control.FEWEST  # what a face costs at least


@given(st.integers(4, 100_000))
def test_levels_end_before_the_finest_has_too_many_faces(faces):
    count = rate_control.level_count_for(faces)
    assert 1 <= count <= rate_control.LEVELS
    assert count == 1 or faces * 4**count <= rate_control.FINEST
    assert count == rate_control.LEVELS or faces * 4 ** (count + 1) > rate_control.FINEST


@given(st.integers(20, 40_000), st.integers(300, 10**6), st.floats(1.001, 50))
def test_fewer_faces_are_fewer(faces, size, over):
    assert rate_control.fewer_faces(faces, int(np.ceil(size * over)), size) < faces or faces <= rate_control.FEWEST // 2
