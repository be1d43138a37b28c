"""The deviation: colours are the distances to the original, and go when they should."""
import bpy
import numpy as np
import pytest

from npm_blender.core.geometry import ClosestPoints

from .conftest import positions


def distances(part, obj):
    """What the core measures."""
    mesh = part("bridge").mesh_of(obj.npmesh.source, bpy.context.evaluated_depsgraph_get())
    return ClosestPoints(mesh).closest(positions(obj).astype(np.float64))[0]


def colours(obj):
    attribute = obj.data.color_attributes["Deviation"]
    found = np.zeros((len(obj.data.vertices), 4), dtype=np.float32)
    attribute.data.foreach_get("color", found.reshape(-1))
    return found


def expected_colours(part, obj):
    module = part("preview.deviation")
    at = np.clip(distances(part, obj) / obj.npmesh.deviation_top, 0, 1)
    return np.array([[*module._linear(np.array(module._colour(x))), 1] for x in at])


def test_distances_are_those_of_the_core(part, previewed):
    nearest = part("preview.nearest")
    mesh = part("bridge").mesh_of(previewed.npmesh.source, bpy.context.evaluated_depsgraph_get())
    P = positions(previewed)
    steps = 0
    surface = nearest.Nearest(mesh)
    for _ in surface.build():
        steps += 1
    asked = surface.distances(P)
    while True:
        try:
            next(asked)
            steps += 1
        except StopIteration as end:
            found = end.value
            break
    assert steps > 2 and np.allclose(found, distances(part, previewed), atol=2e-6)


def test_a_surface_of_many_patches(part, previewed, monkeypatch):
    monkeypatch.setattr(part("preview.nearest"), "PATCH_FACES", 100)
    previewed.npmesh.show_deviation = True
    assert np.allclose(colours(previewed), expected_colours(part, previewed), atol=1e-3)


def test_every_vertex_has_the_colour_of_its_distance(part, previewed):
    previewed.npmesh.features = 25
    previewed.npmesh.show_deviation = True
    assert previewed.npmesh.deviation_problem == ""
    assert np.allclose(colours(previewed), expected_colours(part, previewed), atol=1e-3)
    d = distances(part, previewed)
    assert previewed.npmesh.deviation_mean == pytest.approx(d.mean(), rel=1e-3)
    assert previewed.npmesh.deviation_max == pytest.approx(d.max(), rel=1e-3)
    assert previewed.data.color_attributes.active_color.name == "Deviation"


def test_colours_follow_the_slider_the_level_and_the_scale(part, previewed):
    state = previewed.npmesh
    state.show_deviation = True
    top = state.deviation_top
    for change in (("features", 3), ("level", "1"), ("level", "2"), ("features", state.total_features),
                   ("deviation_top", 0.02)):
        setattr(state, *change)
        assert np.allclose(colours(previewed), expected_colours(part, previewed), atol=1e-3), change
    assert top > 0


def test_the_scale_stays_while_the_slider_moves_and_zero_chooses_anew(previewed):
    state = previewed.npmesh
    state.features = 0
    state.show_deviation = True
    top = state.deviation_top
    state.features = state.total_features
    assert state.deviation_top == top
    state.deviation_top = 0
    assert 0 < state.deviation_top < top


def test_modifiers_of_the_original_count(part, previewed):
    previewed.npmesh.source.modifiers.new("Shift", "DISPLACE").strength = 0.5
    previewed.npmesh.show_deviation = True
    assert previewed.npmesh.deviation_mean > 0.2


def test_turning_it_off_removes_the_colours_of_all_levels(previewed):
    state = previewed.npmesh
    state.show_deviation = True
    state.level = "0"
    state.show_deviation = False
    assert not any(item.mesh.color_attributes or "npmesh_deviation" in item.mesh for item in state.meshes if item.mesh)


def test_without_an_original_the_panel_says_so(opened):
    opened.npmesh.show_deviation = True
    assert "Expected the original, found none" in opened.npmesh.deviation_problem
    assert not opened.data.color_attributes


def test_a_deleted_original_is_named(previewed):
    bpy.data.objects.remove(previewed.npmesh.source)
    previewed.npmesh.show_deviation = True
    assert "Expected the original" in previewed.npmesh.deviation_problem


def views():
    return [space.shading.color_type for screen in bpy.data.screens for area in screen.areas
            for space in area.spaces if space.type == "VIEW_3D"]


@pytest.fixture
def random_colours(part):
    """The choice of the user, in a file with windows."""
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    for screen in bpy.data.screens:
        for area in screen.areas:
            for space in area.spaces:
                if space.type == "VIEW_3D":
                    space.shading.color_type = "RANDOM"
    assert "RANDOM" in views()


@pytest.mark.parametrize("end", ["off", "apply", "discard", "delete"])
def test_viewports_show_attributes_and_then_what_they_showed_before(part, random_colours, received, end):
    from .conftest import add_object

    preview = part("preview")
    obj = preview.make(bpy.context, received, "Shape Preview", add_object())
    before = views()
    obj.npmesh.show_deviation = True
    assert set(views()) == {"VERTEX"}
    if end == "off":
        obj.npmesh.show_deviation = False
    elif end == "apply":
        bpy.ops.object.npmesh_apply()
        assert not obj.data.color_attributes
    elif end == "discard":
        bpy.ops.object.npmesh_discard()
    else:
        bpy.data.objects.remove(obj)
        part("preview.deviation")._watching()
    assert views() == before


def test_another_choice_meanwhile_is_left_alone(part, random_colours, received):
    from .conftest import add_object

    obj = part("preview").make(bpy.context, received, "Shape Preview", add_object())
    obj.npmesh.show_deviation = True
    space = next(s for screen in bpy.data.screens for a in screen.areas for s in a.spaces if s.type == "VIEW_3D")
    space.shading.color_type = "SINGLE"
    obj.npmesh.show_deviation = False
    assert space.shading.color_type == "SINGLE" and set(views()) == {"SINGLE", "RANDOM"}


def test_colours_are_saved_and_follow_after_opening(part, previewed, tmp_path):
    previewed.npmesh.show_deviation = True
    path = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, check_existing=False)
    bpy.ops.wm.open_mainfile(filepath=path)
    obj = bpy.data.objects["Shape Preview"]
    assert np.allclose(colours(obj), expected_colours(part, obj), atol=1e-3)
    obj.npmesh.features = 2
    assert np.allclose(colours(obj), expected_colours(part, obj), atol=1e-3)


def test_the_legend_covers_the_scale(part, previewed):
    previewed.npmesh.show_deviation = True
    entries = part("preview.deviation").legend(previewed.npmesh)
    assert entries[0][0] == pytest.approx(previewed.npmesh.deviation_top) and entries[-1][0] == 0
    assert entries[0][1] == part("preview.deviation").COLOURS[-1] and len({colour for _, colour in entries}) == len(entries)
    assert all(part("panels.common").icon_of(colour) > 0 for _, colour in entries) or bpy.app.background


@pytest.mark.parametrize(("value", "top"), [(0.0013, 0.002), (0.2, 0.2), (0.51, 1), (3.7, 5), (0, 1e-6)])
def test_scales_end_at_round_numbers(part, value, top):
    assert part("preview.deviation")._round_up(value) == pytest.approx(top)


def test_disabling_and_enabling_while_it_is_shown(package, part, random_colours, received):
    import addon_utils

    from .conftest import add_object

    obj = part("preview").make(bpy.context, received, "Shape Preview", add_object())
    before = views()
    obj.npmesh.show_deviation = True
    addon_utils.disable(package)
    try:
        assert views() == before
    finally:
        addon_utils.enable(package, default_set=True)
    assert obj.npmesh.show_deviation
    obj.npmesh.show_deviation = False
    assert not obj.data.color_attributes and views() == before


def test_a_copy_is_coloured_by_itself(part, previewed):
    previewed.npmesh.show_deviation = True
    copy = previewed.copy()
    bpy.context.collection.objects.link(copy)
    copy.npmesh.features = 2
    assert copy.data != previewed.data
    for obj in (copy, previewed):
        assert np.allclose(colours(obj), expected_colours(part, obj), atol=1e-3)


def test_renaming_and_deleting_while_it_is_shown(part, previewed):
    previewed.npmesh.show_deviation = True
    previewed.name = "Other"
    previewed.npmesh.features = 3
    assert np.allclose(colours(previewed), expected_colours(part, previewed), atol=1e-3)
    bpy.data.objects.remove(previewed)
    part("preview").refresh_all()
    assert not part("preview").is_busy()
