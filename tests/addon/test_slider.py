"""The number of features as a share of the way, as bytes to spend, as stops, and what the panel says of their errors."""
import bpy
import pytest

from .conftest import refusal


def error_lines(part, obj):
    return dict(part("panels.preview")._errors(obj, bpy.context.scene))


def test_equal_steps_of_detail_multiply_the_bytes_alike(part, opened):
    progressive, state = part("preview").progressive_of(opened), opened.npmesh
    sizes = []
    for percent in (0, 25, 50, 75, 100):
        state.detail = percent
        sizes.append(state.shown_bytes)
    assert sizes[0] == progressive.base_bytes and sizes[-1] == progressive.total_bytes
    factor = (sizes[-1] / sizes[0]) ** 0.25
    assert [b / a for a, b in zip(sizes, sizes[1:])] == pytest.approx([factor] * 4, rel=0.1)


def test_the_bytes_of_later_bases_take_nothing_of_the_way(part):
    slider, bases = part("preview.slider"), [(1000, 4000), (6000, 16_000)]
    assert [slider._without(bases, size) for size in (500, 1000, 2000, 4000, 5000, 16_500)] == [500, 1000, 1000, 1000, 2000, 3500]
    for size in (500, 999, 4000, 5999, 16_000, 20_000):  # at which more than a base's bytes arrives
        assert slider._with(bases, slider._without(bases, size)) == size
    assert slider._without([], 700) == slider._with([], 700) == 700


def test_detail_stays_where_it_was_put_and_follows_the_features(opened):
    state = opened.npmesh
    state.detail = 37.5
    assert state.detail == pytest.approx(37.5)
    features = state.features
    state.features = 0
    assert state.detail == 0
    state.features = features + 1
    assert state.detail == pytest.approx(37.5, abs=3)
    state.features = state.total_features
    assert state.detail == 100


def test_detail_of_a_plain_base_is_all_there_is(part, tmp_path):
    from npm_blender.core.codec import compress
    from npm_blender.core.settings import CompressSettings, LodSettings

    from .conftest import add_object, triangles

    path = tmp_path / "plain.npmesh"
    ball = triangles(add_object(subdivisions=2))
    path.write_bytes(compress(ball, CompressSettings(LodSettings(base_faces=80), budget=900)).data)
    bpy.ops.import_scene.npmesh(filepath=str(path))
    state = bpy.context.active_object.npmesh
    assert (state.level_count, state.total_features) == (0, 0)
    for percent in (0, 50, 100):
        state.detail = percent
        assert state.features == 0 and state.detail == pytest.approx(percent)


def test_a_budget_picks_the_features_that_fit(part, opened):
    progressive, state = part("preview").progressive_of(opened), opened.npmesh
    least, most = progressive.base_bytes, progressive.total_bytes
    for size in (least, least + 100, 1000, most - 1, most):
        state.budget = size / 1000
        assert state.shown_bytes <= size and state.features == progressive.features_for(size)
        beyond = min(state.features + 100, state.total_features)
        assert beyond == state.features or progressive.bytes_for(beyond) > size


def test_a_budget_stays_what_was_typed_until_the_features_are_set_otherwise(opened):
    opened.npmesh.budget = 1.0
    assert opened.npmesh.budget == pytest.approx(1.0)
    opened.npmesh.features = 0
    assert opened.npmesh.budget == pytest.approx(opened.npmesh.shown_bytes / 1000)


def test_a_budget_below_the_base_gives_the_base(opened):
    opened.npmesh.budget = 0.01
    assert opened.npmesh.features == 0 and opened.npmesh.budget > 0.1


def test_a_budget_beyond_the_stream_gives_all(opened):
    opened.npmesh.budget = 1e6
    assert opened.npmesh.features == opened.npmesh.total_features


def test_the_error_at_a_stop_is_the_measured_one(part, previewed):
    quality = part("preview.storage").quality(previewed["npmesh_measured"])
    for k, features in enumerate(quality.features):
        previewed.npmesh.features = features
        said = error_lines(part, previewed)
        assert " to " not in said["Error"]
        assert float(said["Of Size"].rstrip("%")) == pytest.approx(quality.errors[2][k].worse / 100, rel=0.05)


def test_between_stops_both_ends_are_named(part, previewed):
    quality = part("preview.storage").quality(previewed["npmesh_measured"])
    previewed.npmesh.features = quality.features[1] - 5
    ends = sorted(errors.worse for errors in quality.errors[2][:2])
    said = error_lines(part, previewed)["Of Size"].rstrip("%").split(" to ")
    assert [float(x) for x in said] == pytest.approx([e / 100 for e in ends], rel=0.05)


def test_the_error_is_that_of_the_level(part, previewed):
    fine = error_lines(part, previewed)["Of Size"]
    previewed.npmesh.level = "0"
    assert float(error_lines(part, previewed)["Of Size"].rstrip("%")) > float(fine.rstrip("%"))


def test_of_a_file_without_its_original_the_error_is_not_known(part, opened):
    assert error_lines(part, opened) == {"Error": "not known, no original"}


def test_damaged_errors_are_not_known(part, previewed):
    previewed["npmesh_measured"] = "{"
    assert error_lines(part, previewed) == {"Error": "not known, no original"}


def test_errors_survive_saving(part, previewed, tmp_path):
    before = error_lines(part, previewed)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"), check_existing=False)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    assert error_lines(part, bpy.data.objects["Shape Preview"]) == before


def test_the_worker_measures(part):
    """Compress as the button does: the preview knows its errors."""
    from .conftest import add_object

    add_object(subdivisions=4)
    bpy.ops.object.npmesh_compress(base_faces=80, levels=1)
    shown = bpy.context.active_object
    assert len(part("preview.storage").quality(shown["npmesh_measured"]).errors) == 2
    assert "%" in error_lines(part, shown)["Of Size"]


def test_a_stop_is_one_click_away(previewed):
    bpy.ops.object.npmesh_stop(features=20)
    assert previewed.npmesh.features == 20


def test_stops_need_a_preview():
    assert "Expected a preview" in refusal(bpy.ops.object.npmesh_stop, features=3)


@pytest.mark.parametrize(("count", "text"), [(400, "400"), (1600, "1.6k"), (25_600, "25.6k"), (6_553_600, "6.6M"),
                                             (4000, "4k")])
def test_face_counts_fit_on_buttons(part, count, text):
    assert part("panels.common").short_count(count) == text


@pytest.mark.parametrize("system", ["METRIC", "IMPERIAL", "NONE"])
def test_lengths_in_every_system_of_units(part, system):
    bpy.context.scene.unit_settings.system = system
    text = part("panels.common").length_text(0.012345, bpy.context.scene)
    assert text == {"METRIC": "1.23 cm", "NONE": "0.0123"}.get(system, text) and text
