"""Streams in files of their own: relative paths, checksums, and what is said when the file is gone or another one."""
import shutil

import bpy
import numpy as np
import pytest

from npm_blender.core.codec import open_stream

from .conftest import positions, refusal


def check(part, obj, stream):
    state = obj.npmesh
    V = open_stream(stream).decode_positions(state.features, int(state.level))
    assert state.problem == "" and np.array_equal(positions(obj), V.astype(np.float32))


@pytest.fixture
def linked(previewed, tmp_path):
    """A saved .blend with a preview whose stream is in a file beside it."""
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"), check_existing=False)
    bpy.ops.object.npmesh_link(filepath=str(tmp_path / "shape.npmesh"))
    bpy.ops.wm.save_mainfile()
    return previewed


def reopen(part, path):
    bpy.ops.wm.open_mainfile(filepath=str(path))
    return bpy.data.objects["Shape Preview"]


def test_linking_writes_the_file_and_leaves_the_blend_without_it(part, linked, stream, tmp_path):
    assert (tmp_path / "shape.npmesh").read_bytes() == stream
    assert linked.npmesh.filepath == "//shape.npmesh"
    assert "npmesh_stream" not in linked and "npmesh_stream" not in linked.npmesh.source
    part("preview").forget_all()
    linked.npmesh.features = 7
    check(part, linked, stream)


def test_after_opening_the_file_is_found_again(part, linked, stream, tmp_path):
    obj = reopen(part, tmp_path / "scene.blend")
    obj.npmesh.features, obj.npmesh.level = 9, "1"
    check(part, obj, stream)
    assert part("preview.storage").quality(obj["npmesh_measured"]).features[0] == 0


def test_both_moved_together(part, linked, stream, tmp_path):
    (tmp_path / "there").mkdir()
    for name in ("scene.blend", "shape.npmesh"):
        shutil.move(tmp_path / name, tmp_path / "there" / name)
    obj = reopen(part, tmp_path / "there" / "scene.blend")
    obj.npmesh.features = 9
    check(part, obj, stream)


@pytest.mark.parametrize("copy", [False, True])
def test_saving_elsewhere_keeps_the_link(part, linked, stream, tmp_path, copy):
    (tmp_path / "sub").mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "sub" / "b.blend"), check_existing=False, copy=copy)
    assert linked.npmesh.filepath == ("//shape.npmesh" if copy else "//../shape.npmesh")
    obj = reopen(part, tmp_path / "sub" / "b.blend")
    obj.npmesh.features = 3
    check(part, obj, stream)


def test_before_the_first_save_the_path_is_absolute(part, opened, stream, tmp_path):
    bpy.ops.object.npmesh_link(filepath=str(tmp_path / "a.npmesh"))
    assert opened.npmesh.filepath == str(tmp_path / "a.npmesh")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"), check_existing=False)
    assert opened.npmesh.filepath == "//a.npmesh"


def test_a_missing_file_is_named_and_found_again_by_its_new_path(part, linked, stream, tmp_path):
    shutil.move(tmp_path / "shape.npmesh", tmp_path / "other.npmesh")
    obj = reopen(part, tmp_path / "scene.blend")
    assert "shape.npmesh, found none; check the path" in obj.npmesh.problem and len(obj.data.polygons) == 80 * 16
    obj.npmesh.features = 3
    assert "shape.npmesh, found none" in obj.npmesh.problem
    obj.npmesh.filepath = "//other.npmesh"
    check(part, obj, stream)


def test_a_changed_file_is_refused_until_it_is_reloaded(part, linked, stream, tmp_path):
    (tmp_path / "shape.npmesh").write_bytes(stream[:-40])
    obj = reopen(part, tmp_path / "scene.blend")
    assert "Expected 'shape.npmesh' as it was when it was linked, found another stream" in obj.npmesh.problem
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.npmesh_reload()
    assert obj.npmesh.filepath == "//shape.npmesh" and obj.npmesh.arrived_features < obj.npmesh.total_features
    assert "npmesh_measured" not in obj  # measured on another stream
    check(part, obj, stream[:-40])


def test_reloading_a_damaged_file_keeps_what_is_there(part, linked, tmp_path):
    (tmp_path / "shape.npmesh").write_bytes(b"no stream at all")
    before = positions(linked)
    assert "Expected" in refusal(bpy.ops.object.npmesh_reload)
    assert linked.npmesh.filepath == "//shape.npmesh" and np.array_equal(positions(linked), before)


def test_packing_takes_the_stream_back(part, linked, stream, tmp_path):
    bpy.ops.object.npmesh_pack()
    (tmp_path / "shape.npmesh").unlink()
    part("preview").forget_all()
    assert linked["npmesh_stream"] == stream and linked.npmesh.filepath == ""
    linked.npmesh.features = 5
    check(part, linked, stream)


def test_packing_a_missing_file(linked, tmp_path, part):
    (tmp_path / "shape.npmesh").unlink()
    part("preview").forget_all()
    assert "found none; check the path" in refusal(bpy.ops.object.npmesh_pack)


def test_linking_to_a_folder_that_is_not_there(opened, tmp_path):
    message = refusal(bpy.ops.object.npmesh_link, filepath=str(tmp_path / "no" / "a.npmesh"))
    assert "to exist, found none; create it first" in message
    assert "npmesh_stream" in opened and opened.npmesh.filepath == ""


def test_apply_forgets_the_file(linked):
    bpy.ops.object.npmesh_apply()
    assert linked.npmesh.filepath == "" and not linked.npmesh.is_preview


def test_reload_needs_a_linked_file(opened):
    assert "found its stream packed" in refusal(bpy.ops.object.npmesh_reload)


def test_exporting_a_linked_preview(linked, stream, tmp_path):
    bpy.ops.export_scene.npmesh(filepath=str(tmp_path / "out.npmesh"))
    assert (tmp_path / "out.npmesh").read_bytes() == stream


def test_importing_with_a_link(part, stream_file, stream):
    bpy.ops.import_scene.npmesh(filepath=str(stream_file), link=True)
    obj = bpy.context.active_object
    assert obj.npmesh.filepath == str(stream_file) and "npmesh_stream" not in obj
    part("preview").forget_all()
    obj.npmesh.features = 8
    check(part, obj, stream)


def test_in_a_window_a_worker_reads(part, linked, stream, tmp_path):
    module = part("preview.linked")
    received = module._result(module._job(tmp_path / "shape.npmesh"))
    assert received.data == stream and received.open().features == linked.npmesh.arrived_features


def test_a_job_of_a_file_that_is_no_stream(part, tmp_path):
    (tmp_path / "bad.npmesh").write_bytes(b"no stream at all")
    module = part("preview.linked")
    with pytest.raises(part("core.errors").StreamError, match="Expected"):
        module._result(module._job(tmp_path / "bad.npmesh"))
