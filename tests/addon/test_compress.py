"""Compress: from a selected object to a preview in its place, through the worker process; and every way to refuse."""
import os
import shutil
import subprocess
import time
from pathlib import Path

import bpy
import numpy as np
import pytest

from .conftest import add_object, positions, refusal

SMALL = {"base_faces": 80, "levels": 2}


def leftovers() -> list[str]:
    """Folders of jobs that have not been removed."""
    return [name for name in os.listdir(bpy.app.tempdir) if name.startswith("npmesh_")]


def test_a_preview_takes_the_place_of_the_original(own_process):
    obj = add_object()
    obj.location, obj.rotation_euler, obj.scale = (1, 2, 3), (0.3, 0.2, 0.1), (2, 2, -2)
    bpy.context.view_layer.update()
    obj.data.materials.append(bpy.data.materials.new("Clay"))
    before = positions(obj)
    assert bpy.ops.object.npmesh_compress(**SMALL) == {"FINISHED"}
    shown = bpy.context.active_object
    assert shown.npmesh.is_preview and shown.npmesh.source == obj and obj.hide_get() and not shown.hide_get()
    bpy.context.view_layer.update()
    assert shown.matrix_world == obj.matrix_world
    assert [m.name for m in shown.data.materials] == ["Clay"]
    assert np.array_equal(positions(obj), before)
    assert len(shown.data.polygons) == 80 * 16
    assert np.abs(positions(shown).min(0) - before.min(0)).max() < 0.25
    assert shown.npmesh.source_faces == 5120 and shown.npmesh.source_bytes == 12 * 2562 + 13 * 5120
    assert shown.npmesh.shown_bytes == len(shown["npmesh_stream"]) == len(obj["npmesh_stream"])
    assert not leftovers()


def test_the_settings_stay_with_the_object():
    obj = add_object()
    obj.npmesh.base_faces = 100
    bpy.ops.object.npmesh_compress(levels=1)
    assert (obj.npmesh.base_faces, obj.npmesh.levels) == (100, 1)
    assert len(bpy.context.active_object.data.polygons) == 400


def test_the_base_is_chosen_until_a_number_is_given():
    obj = add_object(subdivisions=4)
    bpy.ops.object.npmesh_compress(levels=1)
    assert obj.npmesh.base_faces == 0 and 100 <= len(bpy.context.active_object.data.polygons) // 4 <= 1280
    bpy.ops.object.npmesh_compress(base_faces=90)
    assert (obj.npmesh.base_faces, obj.npmesh.levels) == (90, 1) and len(bpy.context.active_object.data.polygons) == 90 * 4


@pytest.mark.parametrize("name, least", [("base_faces", 4), ("position_bits", 4), ("levels", 1)])
def test_a_number_is_automatic_or_one_that_can_be(name, least):
    state = add_object().npmesh
    for asked, kept in ((0, 0), (1, least), (-5, 0), (least, least)):
        setattr(state, name, asked)
        assert getattr(state, name) == kept


def test_the_model_of_the_paper_is_one_choice_away(part):
    obj = add_object()
    bpy.ops.object.npmesh_compress(model="paper", base_faces=60, levels=1)
    assert obj.npmesh.model == "paper" and part("preview").progressive_of(bpy.context.active_object).model == "paper"


def test_modifiers_are_applied():
    obj = add_object(subdivisions=4)
    obj.modifiers.new("Finer", "SUBSURF").levels = 1
    obj.modifiers.new("Shift", "DISPLACE").strength = 5
    bpy.ops.object.npmesh_compress(**SMALL)
    shown = bpy.context.active_object
    assert shown.npmesh.source_faces == 2 * 3 * 1280 and np.abs(positions(shown)).max() > 3


def test_compressing_again_updates_the_same_preview():
    add_object()
    bpy.ops.object.npmesh_compress(**SMALL)
    shown = bpy.context.active_object
    bpy.ops.object.npmesh_compress(base_faces=100)
    assert bpy.context.active_object == shown and shown.npmesh.shown_faces == 1600
    assert len(bpy.data.objects) == 2 and len(bpy.data.meshes) == 2


def test_compressing_without_a_preview_and_previewing_later():
    obj = add_object()
    bpy.ops.object.npmesh_compress(make_preview=False, **SMALL)
    assert bpy.context.active_object == obj and not obj.hide_get() and len(bpy.data.objects) == 1
    bpy.ops.object.npmesh_preview()
    shown = bpy.context.active_object
    assert shown.npmesh.source == obj and obj.hide_get()
    bpy.ops.object.npmesh_discard()
    assert bpy.context.active_object == obj and not obj.hide_get() and obj.select_get()


def test_show_original_swaps_the_two():
    obj = add_object()
    bpy.ops.object.npmesh_compress(**SMALL)
    shown = bpy.context.active_object
    shown.npmesh.show_original = True
    assert (obj.hide_get(), shown.hide_get(), shown.npmesh.show_original) == (False, True, True)
    shown.npmesh.show_original = False
    assert (obj.hide_get(), shown.hide_get(), shown.npmesh.show_original) == (True, False, False)


def test_no_object_selected():
    assert "Expected a mesh object, found none selected" in refusal(bpy.ops.object.npmesh_compress)
    add_object().select_set(False)
    assert "Expected a mesh object, found none selected" in refusal(bpy.ops.object.npmesh_compress)


def test_an_object_that_is_no_mesh():
    bpy.ops.object.light_add()
    assert "of another type; convert it to a mesh" in refusal(bpy.ops.object.npmesh_compress)


def test_an_object_in_edit_mode():
    add_object()
    bpy.ops.object.mode_set(mode="EDIT")
    assert "in Object Mode, found it in another" in refusal(bpy.ops.object.npmesh_compress)


def test_an_empty_mesh():
    add_object().data.clear_geometry()
    assert "Expected a mesh with vertices, found none" in refusal(bpy.ops.object.npmesh_compress)


def test_a_mesh_without_faces():
    obj = add_object()
    obj.data.clear_geometry()
    obj.data.vertices.add(3)
    assert "Expected a mesh with faces, found none" in refusal(bpy.ops.object.npmesh_compress)


def test_coordinates_that_are_not_finite():
    add_object().data.vertices[3].co.x = float("nan")
    assert "Expected finite coordinates, found 1" in refusal(bpy.ops.object.npmesh_compress)


def test_an_opened_file_has_no_original(opened):
    assert "which is opened from a file" in refusal(bpy.ops.object.npmesh_compress)


def test_an_original_that_was_removed():
    obj = add_object()
    bpy.ops.object.npmesh_compress(**SMALL)
    for collection in obj.users_collection:
        collection.objects.unlink(obj)
    shown = bpy.context.view_layer.objects.active
    assert "the original of 'Shape Preview'" in refusal(bpy.ops.object.npmesh_compress)
    shown.npmesh.show_original = True
    assert not shown.hide_get() and not shown.npmesh.show_original
    bpy.ops.object.npmesh_discard()
    assert len(bpy.context.view_layer.objects) == 0


def test_previewing_what_is_not_compressed():
    add_object()
    assert "compress it first" in refusal(bpy.ops.object.npmesh_preview)


def test_missing_numba(tmp_path, monkeypatch, own_process):
    import sys

    blocked = tmp_path / "site-packages"
    blocked.mkdir()
    (blocked / "numba.py").write_text("raise ModuleNotFoundError('No module named numba', name='numba')")
    monkeypatch.syspath_prepend(str(blocked))
    assert sys.path[0] == str(blocked)
    add_object()
    message = refusal(bpy.ops.object.npmesh_compress, **SMALL)
    assert "Expected the Python package numba, found none; disable and enable the extension" in message
    assert len(bpy.data.objects) == 1 and not leftovers()


def test_missing_weights(part, tmp_path, monkeypatch, own_process):
    package = tmp_path / "npm_blender"
    shutil.copytree(part("jobs.process").PACKAGE_FOLDER, package, ignore=shutil.ignore_patterns("weights"))  # with compiled code
    monkeypatch.setattr(part("jobs.process"), "PACKAGE_FOLDER", package)
    add_object()
    assert "Expected trained weights" in refusal(bpy.ops.object.npmesh_compress, model="paper", **SMALL)
    assert not leftovers()


def start_job(part, obj, **lod):
    """A job that compresses one object; lod: fields of LodSettings, which leave it little to do."""
    mesh = part("bridge").mesh_of(obj, bpy.context.evaluated_depsgraph_get())
    job = part("jobs").CompressJob([1.0], scratch=bpy.app.tempdir, machine=part("preferences").worker_settings())
    settings = part("core.settings")
    job.add(mesh, settings.CompressSettings(settings.LodSettings(**lod)))
    return job


def alive(pid: int) -> bool:
    """Whether a process runs; a zombie does not."""
    stat = Path(f"/proc/{pid}/stat")
    return stat.exists() and stat.read_text().rpartition(")")[2].split()[0] != "Z"


def test_cancelling_waits_for_no_result_and_leaves_nothing(part, own_process):
    job = start_job(part, add_object(subdivisions=7))
    while not job.poll() and job.fraction < 0.01:
        time.sleep(0.01)
    job.cancel()
    assert job._process.returncode and job.fraction < 1  # killed at work
    assert not leftovers() and part("jobs").running() == ()


def test_progress_raises_to_cancel(part):
    errors = part("core.errors")

    def progress(fraction, message):
        raise errors.Cancelled("Cancelled")

    with pytest.raises(errors.Cancelled):
        start_job(part, add_object(subdivisions=6)).wait(progress)
    assert not leftovers() and part("jobs").running() == ()


def test_progress_never_goes_back(part):
    seen = []
    result, = start_job(part, add_object(subdivisions=4), **SMALL).wait(lambda fraction, message: seen.append(fraction))
    assert seen == sorted(seen) and 0 <= seen[0] <= seen[-1] <= 1 and len(result.stream.data) == result.report["bytes"]


def test_a_crash_of_the_worker_is_no_silence(part, own_process):
    job = start_job(part, add_object(subdivisions=6))
    job._process.kill()
    crash, = job.wait()
    assert isinstance(crash, part("jobs").WorkerCrash) and "ended early" in str(crash)
    assert not leftovers()


@pytest.mark.skipif(not os.path.exists("/proc/self/stat"), reason="looks at processes in /proc")
def test_the_worker_ends_with_its_parent(part, own_process):
    job = start_job(part, add_object(subdivisions=7))
    job._process.stdin.close()  # what the system does for a parent that dies
    deadline = time.monotonic() + 20
    while alive(job._process.pid) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not alive(job._process.pid) and not leftovers()
    job.cancel()


@pytest.mark.skipif(not hasattr(os, "nice"), reason="on Windows a flag of the process says it")
def test_the_worker_goes_behind_the_window(part, own_process):
    job = start_job(part, add_object())
    while not job.poll() and job.message == "Starting":
        time.sleep(0.01)
    behind = os.getpriority(os.PRIO_PROCESS, job._process.pid) - os.getpriority(os.PRIO_PROCESS, 0)
    job.cancel()
    assert behind == min(part("jobs.worker").NICENESS, 19 - os.getpriority(os.PRIO_PROCESS, 0))


SMALLEST = """
import importlib, numpy
codec, mesh, settings = (importlib.import_module(f"{name}.core.{part}") for part in ("codec", "mesh", "settings"))
k = numpy.arange(8)
V = numpy.stack([numpy.cos(0.8 * k), numpy.sin(0.8 * k), 0.3 * (k % 2)], 1)
V = numpy.concatenate([V + (0, 0, z) for z in range(5)])
i, j = (a.ravel() for a in numpy.meshgrid(range(4), range(7), indexing="ij"))
a, b = 8 * i + j, 8 * i + j + 1
sheet = mesh.TriMesh.from_arrays(V, numpy.concatenate([numpy.stack(f, 1) for f in ((a, b, b + 8), (a, b + 8, a + 8))]))
chosen = settings.CompressSettings(lod=settings.LodSettings(base_faces=30, levels=1), model="paper")
assert len(codec.open_stream(codec.compress(sheet, chosen).data).decode().F) > 30
print(sum(m.partition(".")[0] == "npm_blender" for m in sys.modules), sum(m.startswith(name + ".core.") for m in sys.modules))
"""


def test_the_core_runs_under_the_name_that_blender_gives_it(part, tmp_path, as_installed):
    """As in a worker, but uncompiled, so that only this small mesh takes long: 56 faces."""
    process = part("jobs.process")
    *python, bootstrap, name, folder, _ = process.command(tmp_path)
    start, _, _ = bootstrap.partition("runpy.run_module")
    environment = {**process.environment(tmp_path, part("preferences").worker_settings()), "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run([*python, start + SMALLEST, name, folder], env=environment, capture_output=True, text=True)
    plain, own = map(int, done.stdout.split() or (-1, -1))
    assert plain == 0 and own > 30 and name.startswith("bl_ext."), done.stderr


def test_the_worker_never_loads_bpy(part, monkeypatch, own_process):
    process = part("jobs.process")
    command = process.command
    monkeypatch.setattr(process, "command", lambda folder: [command(folder)[0], "-X", "importtime", *command(folder)[1:]])
    job = start_job(part, add_object(subdivisions=4), **SMALL)
    while not job.poll():
        time.sleep(0.05)
    imported = {line.rpartition("|")[2].strip() for line in (job._folder / "err").read_text().splitlines()}
    assert job.result()[0].stream.data
    assert "numpy" in imported and "bpy" not in imported
