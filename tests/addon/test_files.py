"""Import and export: what is written opens again, a cut file opens to what arrived, a bad one says why."""
import bpy
import numpy as np
import pytest

from npm_blender.core.codec import open_stream, receive

from .conftest import add_object, positions, refusal
from .test_compress import SMALL, leftovers


def test_export_and_import_give_the_same_mesh(tmp_path):
    add_object()
    bpy.ops.object.npmesh_compress(**SMALL)
    shown, path = bpy.context.active_object, tmp_path / "out.npmesh"
    bpy.ops.export_scene.npmesh(filepath=str(path))
    assert path.read_bytes() == shown["npmesh_stream"]
    bpy.ops.import_scene.npmesh(filepath=str(path))
    opened = bpy.context.active_object
    assert opened != shown and opened.name == "out" and np.array_equal(positions(opened), positions(shown))


def test_exporting_an_object_compresses_it_once(part, tmp_path, monkeypatch):
    obj = add_object()
    bpy.ops.export_scene.npmesh(filepath=str(tmp_path / "a.npmesh"), **SMALL)
    monkeypatch.setattr(part("jobs"), "CompressJob", None)  # a second job would fail
    bpy.ops.export_scene.npmesh(filepath=str(tmp_path / "b.npmesh"), **SMALL)
    assert (tmp_path / "a.npmesh").read_bytes() == (tmp_path / "b.npmesh").read_bytes()
    assert bpy.context.active_object == obj and len(bpy.data.objects) == 1


def test_exporting_a_changed_object_compresses_it_again(tmp_path):
    obj = add_object()
    bpy.ops.export_scene.npmesh(filepath=str(tmp_path / "a.npmesh"), **SMALL)
    obj.data.vertices[0].co *= 1.5
    bpy.ops.export_scene.npmesh(filepath=str(tmp_path / "b.npmesh"), **SMALL)
    assert (tmp_path / "a.npmesh").read_bytes() != (tmp_path / "b.npmesh").read_bytes()


def test_exporting_only_the_shown_features(opened, stream, tmp_path):
    opened.npmesh.features = 20
    path = tmp_path / "part.npmesh"
    bpy.ops.export_scene.npmesh(filepath=str(path), only_shown=True)
    data = path.read_bytes()
    assert len(data) == opened.npmesh.shown_bytes < len(stream) and stream.startswith(data)
    bpy.ops.import_scene.npmesh(filepath=str(path))
    again = bpy.context.active_object
    assert again.npmesh.arrived_features >= 20 > 0 and again.npmesh.total_features == opened.npmesh.total_features
    again.npmesh.features = 20
    assert np.array_equal(positions(again), positions(opened))


def test_only_shown_features_needs_a_preview(tmp_path):
    add_object()
    message = refusal(bpy.ops.export_scene.npmesh, filepath=str(tmp_path / "a.npmesh"), only_shown=True)
    assert "Expected a preview for Only Shown Features" in message


def test_several_files_at_once(stream, tmp_path):
    for name in ("a", "b", "c"):
        (tmp_path / f"{name}.npmesh").write_bytes(stream)
    files = [{"name": f"{name}.npmesh"} for name in "abc"]
    bpy.ops.import_scene.npmesh(directory=str(tmp_path), files=files)
    assert sorted(o.name for o in bpy.context.selected_objects) == ["a", "b", "c"]


def test_a_file_that_was_cut_off_opens_to_what_arrived(part, stream, tmp_path):
    base = open_stream(stream).base_bytes
    path = tmp_path / "cut.npmesh"
    path.write_bytes(stream[:(base + len(stream)) // 2])
    assert bpy.ops.import_scene.npmesh(filepath=str(path)) == {"FINISHED"}
    state = bpy.context.active_object.npmesh
    assert 0 < state.arrived_features < state.total_features
    state.features = state.total_features
    assert state.features == state.arrived_features


def test_a_file_with_damage_behind_its_base_opens_and_says_so(part, stream, tmp_path, capfd):
    path = tmp_path / "damaged.npmesh"
    path.write_bytes(stream[:-1] + bytes([stream[-1] ^ 4]))
    assert bpy.ops.import_scene.npmesh(filepath=str(path)) == {"FINISHED"}
    state = bpy.context.active_object.npmesh
    assert 0 < state.arrived_features < state.total_features
    assert state.shortfall == open_stream(path.read_bytes()).shortfall and "found a wrong checksum" in state.shortfall
    assert f"'damaged.npmesh' {state.shortfall}" in capfd.readouterr().out


def test_a_whole_file_opens_without_a_warning(opened, capfd):
    assert opened.npmesh.shortfall == "" and "Warning" not in capfd.readouterr().out


BAD_FILES = {
    "empty": lambda data: b"",
    "foreign": lambda data: b"ply\nformat binary_little_endian 1.0\nend_header\n" * 40,
    "ends before the base": lambda data: data[:60],
    "corrupted": lambda data: data[:50] + bytes(255 - b for b in data[50:70]) + data[70:],
}


@pytest.mark.parametrize("damage", BAD_FILES.values(), ids=BAD_FILES.keys())
def test_a_bad_file_gives_one_line_and_leaves_nothing(stream, tmp_path, damage):
    path = tmp_path / "bad.npmesh"
    path.write_bytes(damage(stream))
    message = refusal(bpy.ops.import_scene.npmesh, filepath=str(path))
    assert "'bad.npmesh': Expected" in message and "Traceback" not in message
    assert not bpy.data.objects and not bpy.data.meshes


def test_a_missing_file(tmp_path):
    assert "found none; check the path" in refusal(bpy.ops.import_scene.npmesh, filepath=str(tmp_path / "no.npmesh"))


def test_in_another_mode_one_line_says_so(stream_file):
    obj = add_object()
    bpy.ops.object.mode_set(mode="EDIT")
    assert "Expected Object Mode, found another" in refusal(bpy.ops.import_scene.npmesh, filepath=str(stream_file))
    assert obj.mode == "EDIT" and list(bpy.data.objects) == [obj]


def test_one_bad_file_among_good_ones_does_not_stop_them(stream, tmp_path):
    (tmp_path / "good.npmesh").write_bytes(stream)
    (tmp_path / "bad.npmesh").write_bytes(b"no")
    files = [{"name": "bad.npmesh"}, {"name": "good.npmesh"}]
    assert "'bad.npmesh': Expected" in refusal(bpy.ops.import_scene.npmesh, directory=str(tmp_path), files=files)
    assert [o.name for o in bpy.data.objects] == ["good"]


def test_of_many_files_each_says_what_is_wrong_in_one_line(part, stream, tmp_path, capfd):
    base = open_stream(stream).base_bytes
    contents = {"whole": stream, "cut": stream[:(base + len(stream)) // 2], "empty": b"", "early": stream[:60]}
    for name, data in contents.items():
        (tmp_path / f"{name}.npmesh").write_bytes(data)
    files = [{"name": f"{name}.npmesh"} for name in (*contents, "missing")]
    message = refusal(bpy.ops.import_scene.npmesh, directory=str(tmp_path), files=files)
    for name in ("empty", "early", "missing"):
        assert sum(f"'{name}.npmesh': Expected" in line for line in message.splitlines()) == 1
    assert "'cut.npmesh' ends early: opened with" in message + capfd.readouterr().out
    assert sorted(obj.name for obj in bpy.context.selected_objects) == ["cut", "whole"]
    assert len(bpy.data.objects) == 2


def test_a_wrong_suffix_and_a_missing_folder(opened, tmp_path):
    message = refusal(bpy.ops.export_scene.npmesh, filepath=str(tmp_path / "a.ply"), check_existing=False)
    assert "ends in .npmesh, found 'a.ply'" in message
    message = refusal(bpy.ops.export_scene.npmesh, filepath=str(tmp_path / "no" / "a.npmesh"))
    assert "Expected an existing folder" in message
    assert list(tmp_path.glob("a.*")) == []


def test_the_worker_reads_what_can_be_read(part, stream, tmp_path, as_installed):
    jobs, errors = part("jobs"), part("core.errors")
    base = open_stream(stream).base_bytes
    contents = {"whole": stream, "cut": stream[:(base + len(stream)) // 2], "bad": stream[:60], "empty": b""}
    for name, data in contents.items():
        (tmp_path / f"{name}.npmesh").write_bytes(data)
    paths = [tmp_path / f"{name}.npmesh" for name in (*contents, "missing")]
    job = jobs.ReadJob(paths, bpy.app.tempdir, part("preferences").worker_settings())
    whole, cut, *refused = job.wait()
    assert whole.data == stream and whole.arrays == receive(stream).arrays
    assert cut.data == contents["cut"] and cut.open().features < whole.open().features
    assert [type(error) for error in refused] == [errors.StreamError, errors.FileError, errors.FileError]
    assert not leftovers()


def test_opening_in_a_window_is_left_to_the_worker(part, stream_file, monkeypatch):
    """As in a window, where the operator is invoked and must not block; here the job is waited for at its start."""
    target = part("operators.import_stream")
    operator = target.IMPORT_SCENE_OT_npmesh
    monkeypatch.setattr(target, "_received", None)  # reading in this process would fail
    monkeypatch.setattr(operator, "blocks", lambda self: False)
    monkeypatch.setattr(operator, "run_job",
                        lambda self, context, job: self.run_steps(context, self.finish(context, job.wait())))
    assert bpy.ops.import_scene.npmesh(filepath=str(stream_file)) == {"FINISHED"}
    assert bpy.context.active_object.npmesh.is_preview and bpy.context.active_object.name == "shape"


def test_dropped_files_have_a_handler():
    handler = bpy.types.IO_FH_npmesh
    assert handler.bl_file_extensions == ".npmesh" and handler.bl_import_operator == "import_scene.npmesh"
    group, _, operator = handler.bl_import_operator.partition(".")
    properties = getattr(getattr(bpy.ops, group), operator).get_rna_type().properties
    for name in ("directory", "files", "filepath"):  # what Blender sets; remembered, the next import would not ask
        assert properties[name].is_skip_save
