"""Presets and the time that they take: a preset is its numbers, an estimate learns from the last run."""
from types import SimpleNamespace

import bpy
import pytest

from .conftest import add_object
from .test_batch import QUICK


def test_a_preset_sets_the_numbers_and_a_number_makes_it_custom(part):
    compression = part("properties.compression")
    state = add_object().npmesh
    assert state.preset == "STANDARD"
    for name, (_, _, numbers) in compression.PRESETS.items():
        state.preset = name
        assert state.preset == name and all(getattr(state, key) == value for key, value in numbers.items())
    for key, value in (("base_faces", 123), ("levels", 5), ("position_bits", 9), ("clean", "off"),
                       ("model", "displaced")):
        state.preset = "PAPER"
        setattr(state, key, value)
        assert state.preset == "CUSTOM", key
        state.preset = "CUSTOM"
        assert getattr(state, key) == value


def test_the_presets_name_every_number(part):
    compression = part("properties.compression")
    names = set(compression.SETTING_NAMES) - {"size_limit"}  # any effort may go into any size
    assert all(set(numbers) == names for _, _, numbers in compression.PRESETS.values())
    settings = part("core.settings")
    state = add_object().npmesh
    assert compression.settings_of(state) == settings.CompressSettings()  # the standard is the core's
    state.preset = "PAPER"
    lod = settings.LodSettings(base_faces=settings.PAPER_FACES, levels=settings.PAPER_LEVELS)
    assert compression.settings_of(state) == settings.CompressSettings(lod, model=settings.PAPER)


class Rows:
    """Stands in for a UILayout: remembers what its rows are called."""

    def __init__(self):
        self.texts = []

    def row(self):
        return self

    def prop(self, source, name, text=None):
        assert hasattr(source, name)
        self.texts.append(text)


def test_the_file_browser_shows_what_is_automatic_in_an_operator_too(part):
    """An operator's bl_rna has none of its properties, so it cannot name them."""
    compression, state, rows = part("properties.compression"), add_object().npmesh, Rows()
    compression.draw_settings(rows, SimpleNamespace(**{name: getattr(state, name) for name in compression.SETTING_NAMES}))
    assert [text for text in rows.texts if text] == [
        f"{name} (Automatic)" for name in ("Base Faces", "Levels", "Precision")]


def test_an_operator_takes_a_preset_and_numbers_on_top_of_it():
    obj = add_object(subdivisions=4)
    bpy.ops.object.npmesh_compress(levels=1, base_faces=80, preset="DRAFT")
    assert (obj.npmesh.levels, obj.npmesh.base_faces) == (1, 80)
    assert obj.npmesh.preset == "CUSTOM"


def test_a_size_limit_chooses_base_and_levels_and_is_kept(part):
    compression = part("properties.compression")
    obj = add_object(subdivisions=4)
    bpy.ops.object.npmesh_compress(size_limit=0.8, preset="DRAFT", make_preview=False)
    assert obj.npmesh.preset == "DRAFT" and obj.npmesh.base_faces == 400 and obj.npmesh.size_limit == pytest.approx(0.8)
    settings = compression.settings_of(obj.npmesh)
    assert (settings.budget, settings.lod.base_faces, settings.lod.levels) == (800, 0, 0)
    stream = part("preview").packed(obj)
    assert 600 < len(stream.data) <= 800
    bpy.ops.object.npmesh_compress(base_faces=80, levels=1, make_preview=False)
    assert obj.npmesh.size_limit == 0 and part("preview").packed(obj).open().base_faces == 80


@pytest.mark.parametrize("asked, kept", [(0.1, 0.3), (0.3, 0.3), (2.5, 2.5), (0.0, 0.0)])
def test_a_size_limit_is_none_or_one_that_a_file_can_keep_to(asked, kept):
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.npmesh.size_limit = asked
    assert bpy.context.object.npmesh.size_limit == pytest.approx(kept)


def test_the_smallest_file_keeps_to_its_size(part):
    obj = add_object(subdivisions=4)
    bpy.ops.object.npmesh_compress(size_limit=0.2, preset="DRAFT", make_preview=False)
    assert obj.npmesh.size_limit == pytest.approx(0.3)
    assert len(part("preview").packed(obj).data) <= 300


def test_a_size_limit_leaves_the_numbers_of_the_paper_alone(part):
    state = add_object().npmesh
    state.preset, state.size_limit = "PAPER", 2.5
    settings = part("properties.compression").settings_of(state)
    assert (settings.budget, settings.lod.base_faces, settings.lod.levels) == (2500, 400, 3)


def test_more_costs_more(part):
    compression, rates = part("properties.compression"), part("jobs.estimate").Rates()
    state = add_object().npmesh
    state.preset = "DRAFT"
    draft = rates.seconds(100_000, compression.settings_of(state))
    state.preset = "STANDARD"
    standard = rates.seconds(100_000, compression.settings_of(state))
    assert draft < standard < rates.seconds(10**6, compression.settings_of(state))
    state.base_faces, state.levels = 2000, 4
    assert rates.seconds(100_000, compression.settings_of(state)) > standard


@pytest.mark.parametrize("faces", [100, 1_280, 10_000, 90_000, 10**6])
def test_what_the_core_chooses_is_guessed_as_it_does(part, faces):
    from npm_blender.core.codec.displaced_sender import default_faces
    from npm_blender.core.codec.fitted_base import levels_for

    settings = part("core.settings")
    base = default_faces(faces)
    found = part("jobs.estimate").finest_faces(faces, settings.CompressSettings())
    assert found in [base * 4 ** (levels_for(base, faces) + k) for k in (-1, 0, 1)]
    base = 2000
    found = part("jobs.estimate").finest_faces(faces, settings.CompressSettings(settings.LodSettings(base_faces=base)))
    assert found in [base * 4 ** (levels_for(base, faces) + k) for k in (-1, 0, 1)]


@pytest.mark.parametrize("told", [{}, {"budget": 2000}, {"model": "paper"}])
def test_the_last_run_sets_the_rate_of_its_kind(part, tmp_path, told):
    estimate = part("jobs.estimate")
    settings = part("core.settings").CompressSettings(**told)
    lod = {"model": (400, 3)}.get(next(iter(told), ""), (800, 3))
    report = {"seconds": {"clean": 1.0, "fit": 20.0, "details": 3.5, "write": 0.5}, "faces": 50_000, "base_faces": lod[0],
              "levels": {800: 4}.get(lod[0], lod[1])}
    rates = estimate.learned(estimate.Rates(), report, settings, 2.0)
    assert rates.start == 2.0 and rates.seconds(50_000, settings) == pytest.approx(25.0)
    assert sum(getattr(rates, kind) != 1 for kind in ("displaced", "sized", "paper")) == 1
    estimate.save(str(tmp_path), rates)
    assert estimate.load(str(tmp_path)) == rates


@pytest.mark.parametrize("content", [None, "", "no", "[]", '{"speed": 1}', '{"start": "a"}'])
def test_damaged_rates_count_as_none(part, tmp_path, content):
    estimate = part("jobs.estimate")
    if content is not None:
        (tmp_path / estimate.FILE).write_text(content)
    assert estimate.load(str(tmp_path)) == estimate.Rates()
    estimate.save(str(tmp_path / "missing"), estimate.Rates())


def test_what_is_left_starts_with_the_estimate_and_ends_with_nothing(part):
    left = part("jobs.estimate").remaining
    assert left(60, 0.0, 0.0) == 60 and left(60, 1.0, 40) == 0
    assert left(60, 0.5, 60) == pytest.approx(45)  # half the work took all the estimate: between 30 and 60
    assert left(60, 0.9, 108) == pytest.approx(11.4)


@pytest.mark.parametrize(("seconds", "text"), [
    (0.2, "1 s"), (4.1, "5 s"), (12, "15 s"), (61, "65 s"), (100, "2 min"), (5399, "90 min"), (7200, "2.0 h")])
def test_durations_as_people_say_them(part, seconds, text):
    assert part("jobs.estimate").text(seconds) == text


def test_compressing_teaches(part, monkeypatch):
    expected, estimate, kept = part("operators.expected_time"), part("jobs.estimate"), []
    monkeypatch.setattr(expected, "_rates", [estimate.Rates()])
    monkeypatch.setattr(estimate, "save", lambda folder, rates: kept.append(rates))
    add_object(subdivisions=4)
    bpy.ops.object.npmesh_compress(**QUICK)
    rates = expected.rates()
    assert kept == [rates] and rates.displaced != 1 and (rates.sized, rates.paper) == (1, 1)
    assert 0 < rates.displaced < 1000 and rates.start > 0
