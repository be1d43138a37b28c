"""A budget in bytes: it is kept, it is filled, and more of it shows more."""
from functools import cache

import pytest

from npm_blender.core.codec import compress, open_stream
from npm_blender.core.errors import Cancelled, SettingsError
from npm_blender.core.evaluation import evaluate
from npm_blender.core.settings import CompressSettings, LodSettings
from tests.core.codec.streams import silent
from tests.few_points import compare_by_few_points
from tests.meshes.dirty_meshes import many_parts
from tests.meshes.shapes import bumpy, grid

SHAPES = {"closed": bumpy(4), "open": grid(48)}
BUDGETS = (500, 900, 1_600)
FILLED = 0.95  # steps are of a sixteenth of an octave


ANY = LodSettings()


def limited(size, lod=ANY):
    return CompressSettings(lod=lod, budget=size)


@pytest.fixture(scope="module", autouse=True)
def quick_streams():
    """What the search decides by differs from point to point by far more than by how many there are."""
    with pytest.MonkeyPatch.context() as patch:
        compare_by_few_points(patch)
        yield


@cache
def made(name, size):
    return compress(SHAPES[name], limited(size), silent)


def worse(name, size):
    found = evaluate(open_stream(made(name, size).data).decode(), SHAPES[name], 20_000)
    return max(found.d_pm, found.d_reverse)


@pytest.mark.slow
@pytest.mark.parametrize("size", BUDGETS)
@pytest.mark.parametrize("name", SHAPES)
def test_the_file_is_whole_and_fills_the_budget(name, size):
    done = made(name, size)
    opened = open_stream(done.data)
    assert len(done.data) <= size and (size < 900 or FILLED * size <= len(done.data))  # few bytes: more may not help
    assert not opened.truncated and opened.features == opened.total_features == done.report.features


@pytest.mark.slow
@pytest.mark.parametrize("name", SHAPES)
def test_more_bytes_show_more(name):
    errors = [worse(name, size) for size in BUDGETS]
    assert errors == sorted(errors, reverse=True) and errors[0] > 2 * errors[-1]


@pytest.mark.slow
def test_a_size_is_worth_more_than_a_part_of_a_larger_file():
    whole = compress(SHAPES["closed"], CompressSettings(LodSettings(base_faces=200, levels=2)), silent).data
    cut = open_stream(whole[:1_600]).decode()
    found = evaluate(cut, SHAPES["closed"], 20_000)
    assert worse("closed", 1_600) < max(found.d_pm, found.d_reverse)


@pytest.mark.slow
def test_base_faces_and_levels_that_were_asked_for_are_obeyed():
    lod = LodSettings(base_faces=100, levels=2)
    opened = open_stream(compress(SHAPES["closed"], limited(900, lod), silent).data)
    assert (opened.base_faces, opened.levels) == (100, 2) and opened.total_bytes <= 900


@pytest.mark.slow
def test_a_base_that_was_asked_for_and_does_not_fit_is_refused():
    with pytest.raises(SettingsError, match=r"Expected a base mesh of at most 300 bytes, found .* for 400 faces; allow more"):
        compress(SHAPES["closed"], limited(300, LodSettings(base_faces=400)), silent)


@pytest.mark.slow
def test_a_mesh_of_many_parts_is_given_fewer_faces_or_refused():
    assert len(compress(many_parts(8), limited(900), silent).data) <= 900
    with pytest.raises(SettingsError, match="Expected a base mesh of at most 300 bytes, found .* allow more bytes"):
        compress(many_parts(100), limited(300), silent)


def test_a_search_can_be_cancelled():
    def cancel(fraction, message):
        if fraction > 0.15:
            raise Cancelled("Cancelled")

    with pytest.raises(Cancelled):
        compress(SHAPES["open"], limited(700), cancel)


def test_impossible_budgets_are_refused():
    for size in (-1, 1, 299, 10**10, True, 1000.0):
        with pytest.raises(SettingsError, match="Expected budget in bytes"):
            CompressSettings(budget=size)


@pytest.mark.slow
@pytest.mark.parametrize("lod", [LodSettings(levels=2), LodSettings(base_faces=5_000, levels=1)], ids=["levels", "both"])
def test_levels_that_are_asked_for_are_had_where_the_budget_pays_for_the_whole_mesh(lod):
    report = compress(bumpy(3), limited(8_000, lod), silent).report
    assert (report.base_faces, report.levels) == (len(bumpy(3).F), lod.levels) and report.bytes <= 8_000
