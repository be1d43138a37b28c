"""The preview: what its mesh shows is exactly what the core decodes, whatever the user does with the properties."""
import threading

import bpy
import numpy as np
import pytest

from npm_blender.core.codec import open_stream

from .conftest import positions, refusal


def decoded(part, obj):
    """What the core makes of the preview's stream at its level and number of features."""
    state = obj.npmesh
    progressive = open_stream(obj["npmesh_stream"])
    return progressive.decode(features=state.features, level=int(state.level))


def check(part, obj):
    mesh = decoded(part, obj)
    assert np.array_equal(positions(obj), mesh.V.astype(np.float32))
    faces = np.zeros(3 * len(obj.data.polygons), dtype=np.int32)
    obj.data.loops.foreach_get("vertex_index", faces)
    assert np.array_equal(faces.reshape(-1, 3), mesh.F)


def test_opens_at_the_finest_level_with_all_features(part, opened):
    state = opened.npmesh
    assert (state.level, state.features) == ("2", state.total_features)
    assert state.shown_faces == len(opened.data.polygons) == 80 * 16
    check(part, opened)


def test_every_stop_of_the_slider_is_the_cores_mesh(part, opened):
    total = opened.npmesh.total_features
    for features in (0, 1, total // 7, total // 2, total - 1, total, 3):
        opened.npmesh.features = features
        check(part, opened)


def test_every_level_is_the_cores_mesh(part, opened):
    for level in ("0", "2", "1", "0", "2"):
        opened.npmesh.level = level
        check(part, opened)


def test_bytes_grow_with_features_and_end_at_the_files_size(opened, stream):
    state, sizes = opened.npmesh, []
    for features in range(0, state.total_features + 1, 25):
        state.features = features
        sizes.append(state.shown_bytes)
    state.features = state.total_features
    sizes.append(state.shown_bytes)
    assert sizes == sorted(sizes) and sizes[0] < sizes[-1] <= len(stream)


def test_moving_the_slider_keeps_the_datablock_and_normals_follow(opened):
    opened.npmesh.features = 0
    mesh = opened.data
    before = np.array(mesh.polygons[7].normal)
    opened.npmesh.features = opened.npmesh.total_features
    V = positions(opened)[list(mesh.polygons[7].vertices)]
    normal = np.cross(V[1] - V[0], V[2] - V[0])
    assert opened.data == mesh
    assert np.allclose(mesh.polygons[7].normal, normal / np.linalg.norm(normal), atol=1e-4)
    assert not np.allclose(mesh.polygons[7].normal, before, atol=1e-6)


def test_a_level_is_built_once(opened):
    names = []
    for level in ("1", "2", "1", "2"):
        opened.npmesh.level = level
        names.append(opened.data.name)
    assert names[:2] == names[2:] and len(bpy.data.meshes) == 2


def test_setting_the_same_value_again_writes_nothing(opened):
    opened.npmesh.features = 5
    opened.data.vertices[0].co.x += 1
    moved = opened.data.vertices[0].co.x
    opened.npmesh.features = 5
    assert opened.data.vertices[0].co.x == moved


@pytest.mark.parametrize(("name", "value"), [("features", 5), ("level", "1"), ("detail", 50), ("budget", 0.5)])
def test_blender_evaluates_what_has_changed_and_nothing_else(opened, name, value):
    def tagged():
        seen = []
        bpy.app.handlers.depsgraph_update_post.append(lambda scene, depsgraph: seen.extend(u.id.name for u in depsgraph.updates))
        setattr(opened.npmesh, name, value)
        bpy.context.view_layer.update()
        bpy.app.handlers.depsgraph_update_post.pop()
        return seen

    bpy.context.view_layer.update()
    assert opened.name in tagged()
    assert tagged() == []  # set again


def test_values_beyond_the_stream_are_clamped(opened):
    opened.npmesh.features = 10**6
    opened.npmesh.level = "6"
    assert (opened.npmesh.features, opened.npmesh.level) == (opened.npmesh.total_features, "2")


@pytest.mark.parametrize("percent", [0, 10, 50, 75, 100])
def test_detail_is_another_view_of_the_features(opened, percent):
    opened.npmesh.detail = percent
    features = opened.npmesh.features
    assert opened.npmesh.detail == pytest.approx(percent)
    opened.npmesh.detail = opened.npmesh.detail
    assert opened.npmesh.features == features


def test_an_edited_level_is_built_again(part, opened):
    opened.data.clear_geometry()
    opened.npmesh.features = 4
    check(part, opened)


def test_a_copy_has_its_own_meshes(part, opened):
    opened.npmesh.level = "1"
    copy = opened.copy()
    bpy.context.collection.objects.link(copy)
    copy.npmesh.features = 2
    assert copy.data != opened.data
    check(part, copy)
    opened.npmesh.features = opened.npmesh.total_features - 1
    check(part, opened)
    check(part, copy)


def test_materials_follow_from_level_to_level(opened):
    material = bpy.data.materials.new("Clay")
    opened.data.materials.append(material)
    for level in ("0", "1", "2"):
        opened.npmesh.level = level
        assert list(opened.data.materials) == [material]


def test_survives_saving_and_opening_the_file(part, opened, tmp_path):
    opened.npmesh.level, opened.npmesh.features = "1", 11
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"), check_existing=False)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    obj = bpy.data.objects["shape"]
    assert (obj.npmesh.level, obj.npmesh.features) == ("1", 11)
    check(part, obj)
    obj.npmesh.level = "2"
    obj.npmesh.features = 12
    check(part, obj)


def test_survives_renaming(part, opened):
    opened.name, opened.data.name = "Other", "Mesh of Another Name"
    opened.npmesh.features = 9
    check(part, opened)


def test_refreshing_restores_what_undo_took_away(part, opened):
    opened.npmesh.features = 30
    opened.data["npmesh_shown"] = "an older state"
    positions_before = positions(opened)
    opened.data.vertices.foreach_set("co", np.zeros(positions_before.size, dtype=np.float32))
    part("preview").refresh_all()
    assert np.array_equal(positions(opened), positions_before)


def test_a_lost_stream_is_named_in_the_panel(part, opened):
    del opened["npmesh_stream"]
    part("preview").forget_all()
    opened.npmesh.features = 1
    assert "found none; open the file again" in opened.npmesh.problem


def test_a_stream_without_what_was_read_from_it_opens_too(part, opened):
    del opened["npmesh_arrays"]
    part("preview").forget_all()
    opened.npmesh.features = 1
    assert opened.npmesh.problem == ""
    check(part, opened)


def test_damaged_arrays_are_named_in_the_panel(part, opened):
    arrays = opened["npmesh_arrays"]
    del opened["npmesh_arrays"]
    opened["npmesh_arrays"] = arrays[:100]
    part("preview").forget_all()
    opened.npmesh.features = 1
    assert "damaged arrays" in opened.npmesh.problem


def test_a_preview_of_another_file_is_left_alone(opened, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"), check_existing=False)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, linked):
        linked.objects = ["shape"]
    bpy.context.collection.objects.link(linked.objects[0])
    bpy.context.view_layer.objects.active = linked.objects[0]
    for operator in (bpy.ops.object.npmesh_apply, bpy.ops.object.npmesh_discard, bpy.ops.object.npmesh_compress):
        assert "make it local first" in refusal(operator)


def test_apply_leaves_an_ordinary_object(opened):
    opened.npmesh.level = "1"
    before = positions(opened)
    bpy.ops.object.npmesh_apply()
    assert not opened.npmesh.is_preview and "npmesh_shown" not in opened.data
    assert "npmesh_stream" not in opened and "npmesh_arrays" not in opened
    assert np.array_equal(positions(opened), before)
    assert [m.name for m in bpy.data.meshes] == [opened.data.name]


def test_discard_leaves_nothing(opened):
    for level in ("0", "1", "2"):
        opened.npmesh.level = level
    bpy.ops.object.npmesh_discard()
    assert not bpy.data.objects and not bpy.data.meshes


def test_nothing_changes_in_edit_mode(opened):
    opened.npmesh.features = 5
    bpy.ops.object.mode_set(mode="EDIT")
    opened.npmesh.features = 6
    bpy.ops.object.mode_set(mode="OBJECT")
    assert opened.data["npmesh_shown"].endswith(":5")


def test_work_in_a_thread_gives_its_result_or_its_error(part):
    def run(work):
        steps = part("preview.threads").in_thread(work)
        while True:
            try:
                next(steps)
            except StopIteration as end:
                return end.value

    caller = threading.get_ident()
    assert run(threading.get_ident) != caller
    with pytest.raises(ZeroDivisionError):
        run(lambda: 1 // 0)
    assert run(lambda: np.arange(3).sum()) == 3 and threading.get_ident() == caller
