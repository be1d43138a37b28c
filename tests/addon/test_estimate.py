"""Presets and the time that they take: a preset is its numbers, an estimate learns from the last run."""
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
    for key, value in (("base_faces", 123), ("levels", 5), ("position_bits", 9), ("clean", "off"), ("refine_steps", 7),
                       ("auto_base", True)):
        state.preset = "BEST"
        setattr(state, key, value)
        assert state.preset == "CUSTOM", key
        state.preset = "CUSTOM"
        assert getattr(state, key) == value


def test_the_presets_name_every_number(part):
    compression = part("properties.compression")
    names = set(compression.SETTING_NAMES) - {"size_limit"}  # any effort may go into any size
    assert all(set(numbers) == names for _, _, numbers in compression.PRESETS.values())
    assert compression.PRESETS["STANDARD"][2]["refine_steps"] == part("core.settings").REFINE_STEPS


def test_an_operator_takes_a_preset_and_numbers_on_top_of_it():
    obj = add_object(subdivisions=4)
    bpy.ops.object.npmesh_compress(levels=1, base_faces=80, preset="DRAFT")
    assert (obj.npmesh.levels, obj.npmesh.base_faces, obj.npmesh.refine_steps) == (1, 80, 0)
    assert obj.npmesh.preset == "CUSTOM"


def test_a_size_limit_chooses_base_and_levels_and_is_kept(part):
    compression = part("properties.compression")
    obj = add_object(subdivisions=5)
    bpy.ops.object.npmesh_compress(size_limit=1.2, preset="DRAFT", make_preview=False)
    assert obj.npmesh.preset == "DRAFT" and obj.npmesh.size_limit == pytest.approx(1.2)
    settings = compression.settings_of(obj.npmesh)
    assert (settings.budget, settings.lod.base_faces, settings.lod.levels) == (1200, 0, 0)
    stream = part("preview").packed(obj)
    assert 1000 < len(stream.data) <= 1200
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


def test_more_costs_more(part):
    compression, rates = part("properties.compression"), part("jobs.estimate").Rates()
    state = add_object().npmesh
    seconds = []
    for name in ("DRAFT", "STANDARD", "BEST"):
        state.preset = name
        seconds.append(rates.seconds(100_000, compression.settings_of(state)))
    assert seconds == sorted(seconds) and seconds[0] < seconds[2] / 10
    assert rates.seconds(10**6, compression.settings_of(state)) > seconds[2]


def test_the_last_run_sets_the_rates(part, tmp_path):
    estimate = part("jobs.estimate")
    settings = part("core.settings").CompressSettings(refine_steps=10)
    stages = {"clean": 1.0, "decimate": 2.0, "levels": 1.0, "encode": 0.5, "refine": 20.0, "order": 0.25, "write": 0.25}
    report = {"seconds": stages, "faces": 50_000, "base_faces": 400, "levels": 3}
    rates = estimate.learned(estimate.Rates(), report, settings, 2.0)
    assert rates.start == 2.0 and rates.seconds(50_000, settings) == pytest.approx(25.0)
    without_torch = {**report, "seconds": {k: v for k, v in stages.items() if k != "refine"}}
    assert estimate.learned(rates, without_torch, settings, None).per_step == rates.per_step
    unrefined = part("core.settings").CompressSettings(refine_steps=0)
    assert estimate.learned(rates, report, unrefined, None).per_step == rates.per_step
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


def test_without_torch_no_refinement_is_estimated(part, monkeypatch):
    expected, settings = part("operators.expected_time"), part("core.settings").CompressSettings(refine_steps=50)
    obj, seconds = add_object(subdivisions=4), {}
    monkeypatch.setattr(expected, "_rates", [part("jobs.estimate").Rates()])  # not what this machine has learned
    for there in (True, False):
        monkeypatch.setattr(part("preferences"), "finds_torch", lambda there=there: there)
        seconds[there], = expected.expected_seconds([obj], settings, bpy.context.view_layer.depsgraph)
    assert seconds[False] < seconds[True] / 10


def test_compressing_teaches(part, monkeypatch):
    expected, estimate, kept = part("operators.expected_time"), part("jobs.estimate"), []
    monkeypatch.setattr(expected, "_rates", [estimate.Rates()])
    monkeypatch.setattr(estimate, "save", lambda folder, rates: kept.append(rates))
    add_object(subdivisions=4)
    bpy.ops.object.npmesh_compress(**QUICK)
    rates = expected.rates()
    assert kept == [rates] and rates != estimate.Rates() and rates.per_step == estimate.Rates().per_step
    assert 0 < rates.per_face < 0.1 and rates.start > 0
