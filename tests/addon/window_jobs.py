"""Checks of compressing, exporting and opening in a window; see run_in_window.py."""
import shutil
import subprocess
import time
from pathlib import Path

import bpy

from .window_driver import (
    PACKAGE,
    STALL_SECONDS,
    active,
    busy,
    compressed,
    fresh_object,
    gaps,
    in_viewport,
    leftovers,
    module,
    redraw_stall,
    say,
    shown_is_decoded,
    start_compressing,
    until,
    until_idle,
)


def check_compressing_keeps_the_window_alive():
    name = fresh_object(7).name
    yield 1.0
    redraw = yield from redraw_stall()
    start = time.perf_counter()
    start_compressing()
    took = time.perf_counter() - start
    gaps.clear()
    while module("jobs").running():
        yield 0.05
    while_running = max(gaps)
    gaps.clear()
    yield from until(lambda: active().npmesh.is_preview, 5)
    assert active().npmesh.source.name == name
    shown_is_decoded(active())
    say(f"  starting took {1000 * took:.0f} ms; the longest stall was {1000 * while_running:.0f} ms while it ran, "
        f"{1000 * max(gaps):.0f} ms at its end (redrawing alone: {1000 * redraw:.0f} ms)")


def check_the_longest_stall_of_100k_faces():
    """Each part of a job: at most STALL_SECONDS of the window's own thread, beyond what drawing costs."""
    name = fresh_object(2).name
    with in_viewport():
        bpy.data.objects.remove(bpy.data.objects[name])
        bpy.ops.mesh.primitive_uv_sphere_add(segments=400, ring_count=126)
    obj = active()
    faces = sum(len(p.vertices) - 2 for p in obj.data.polygons)
    yield 1.0
    busy.clear()
    redraw = yield from redraw_stall()
    drawing = max(busy)
    start, spent = time.perf_counter(), time.thread_time()
    start_compressing()
    took, spent = time.perf_counter() - start, time.thread_time() - spent
    gaps.clear()
    busy.clear()
    while module("jobs").running():
        yield 0.05
    running, running_busy = max(gaps), max(busy)
    gaps.clear()
    busy.clear()
    yield from until(lambda: active().npmesh.is_preview)
    say(f"  {faces:,} faces, longest stalls in ms, and of the window's own thread: starting {1000 * took:.0f}, "
        f"{1000 * spent:.0f}; while it ran {1000 * running:.0f}, {1000 * running_busy:.0f}; at its end "
        f"{1000 * max(gaps):.0f}, {1000 * max(busy):.0f}; drawing alone {1000 * redraw:.0f}, {1000 * drawing:.0f}")
    assert max(spent, running_busy - drawing, max(busy) - drawing) <= STALL_SECONDS, "the window stands still for too long"


def several_objects(subdivisions: int) -> list[str]:
    """The names of three objects, selected, the last one active, ready to compress quickly."""
    fresh_object(subdivisions)
    with in_viewport():
        first = active()
        for k in (1, 2):
            bpy.ops.object.duplicate()
            obj = active()
            obj.location.x, obj.scale = 3 * k, (1, 1, 1 + k / 10)
            bpy.ops.object.transform_apply(location=False)
        for obj in bpy.context.view_layer.objects:
            obj.select_set(True)
        bpy.ops.ed.undo_push(message="Three Objects")
    assert first.npmesh.levels == active().npmesh.levels
    return [o.name for o in bpy.context.view_layer.objects]


def check_several_objects_are_one_job_and_one_undo_step():
    names = several_objects(5)
    yield 0.5
    start_compressing()
    assert len(module("jobs").running()) == 1
    job = module("jobs").running()[0]
    seen = set()
    while module("jobs").running():
        seen.add(job.doing)
        assert job.seconds_left() is not None
        yield 0.02
    yield from until(lambda: len(bpy.context.view_layer.objects) == 6)
    yield 0.5
    assert any(said.endswith("(2 of 3)") for said in seen), seen
    assert {o.npmesh.source.name for o in bpy.context.selected_objects} == set(names)
    for obj in bpy.context.selected_objects:
        shown_is_decoded(obj)
    with in_viewport():
        bpy.ops.ed.undo()
    yield 0.3
    assert {o.name for o in bpy.context.view_layer.objects if not o.hide_get()} == set(names), "undo is not one step"
    assert not any(o.npmesh.is_preview for o in bpy.data.objects)
    with in_viewport():
        bpy.ops.ed.redo()
    yield 0.3
    assert sum(o.npmesh.is_preview for o in bpy.data.objects) == 3


def check_one_cancel_ends_all_of_several():
    names = several_objects(7)
    meshes = len(bpy.data.meshes)
    yield 0.5
    start_compressing()
    job = module("jobs").running()[0]
    yield from until(lambda: job.position == 1)
    pid = job._process.pid
    start = time.perf_counter()
    bpy.ops.object.npmesh_cancel()
    took = time.perf_counter() - start
    yield 0.3
    assert took < 0.5 and not module("jobs").running() and not leftovers() and not Path(f"/proc/{pid}").exists()
    assert sorted(o.name for o in bpy.data.objects) == sorted(names) and len(bpy.data.meshes) == meshes
    assert not any("npmesh_stream" in o for o in bpy.data.objects)
    say(f"  cancelled the second of three after {1000 * took:.0f} ms")


def browsers() -> list[bpy.types.Area]:
    """The file browsers that are open."""
    return [a for w in bpy.context.window_manager.windows for a in w.screen.areas if a.type == "FILE_BROWSER"]


def browse(confirm: bool, path: Path | None = None):
    """Wait for the file browser, choose `path` in it, then press its button or close it."""
    yield from until(lambda: browsers() and browsers()[0].spaces.active.params)
    yield 0.5
    area = browsers()[0]
    if path is not None:
        params = area.spaces.active.params
        params.directory, params.filename = str(path.parent).encode(), path.name
    region = next(r for r in area.regions if r.type == "WINDOW")
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=area, region=region):
        bpy.ops.file.execute() if confirm else bpy.ops.file.cancel()
    yield from until(lambda: not browsers())


def check_exporting_from_the_file_browser():
    obj = fresh_object(5)
    path = Path(bpy.app.tempdir, "window.npmesh")
    for confirm in (False, True):
        with in_viewport():
            bpy.ops.export_scene.npmesh("INVOKE_DEFAULT", filepath=str(path))
        yield from browse(confirm)
        if confirm:
            yield from until(path.exists)
        yield from until_idle()
        assert path.exists() == confirm
    assert path.read_bytes() == obj["npmesh_stream"] and not obj.npmesh.is_preview


def written(*names: str, data: bytes | None = None) -> Path:
    """A new folder with a stream, the active object's if none is given, under these names, some cut off or damaged."""
    folder = Path(bpy.app.tempdir, "dropped")
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    data = data or active()["npmesh_stream"]
    for name in names:
        part = data[:-50] if "cut" in name else data[:60] if "bad" in name else data
        (folder / name).write_bytes(part)
    return folder


def check_dropping_files():
    """As Blender's drop of files: the handler's poll, then its operator, invoked with directory, files and filepath."""
    yield from compressed(5)
    names = ("a.npmesh", "cut.npmesh", "b.npmesh")
    folder = written(*names)
    handler = bpy.types.IO_FH_npmesh
    group, _, operator = handler.bl_import_operator.partition(".")
    with in_viewport():
        assert handler.poll_drop(bpy.context)
        gaps.clear()
        result = getattr(getattr(bpy.ops, group), operator)(
            "INVOKE_DEFAULT", directory=str(folder), files=[{"name": name} for name in names],
            filepath=str(folder / names[0]))
    assert result == {"RUNNING_MODAL"}, result
    yield from until_idle()
    opened = {o.name: o for o in bpy.context.selected_objects}
    assert set(opened) == {"a", "cut", "b"}, sorted(opened)
    assert opened["cut"].npmesh.arrived_features < opened["cut"].npmesh.total_features
    for obj in opened.values():
        shown_is_decoded(obj)
    say(f"  the longest stall while three files opened was {1000 * max(gaps):.0f} ms")
    with in_viewport():
        bpy.ops.ed.undo()
    yield 0.3
    assert not {"a", "cut", "b"} & set(bpy.data.objects.keys()), "undo leaves opened files"


def check_importing_from_the_file_browser():
    yield from compressed(5)
    folder = written("one.npmesh")
    for confirm in (False, True):
        with in_viewport():
            bpy.ops.import_scene.npmesh("INVOKE_DEFAULT")
        yield from browse(confirm, folder / "one.npmesh")
        if confirm:
            yield from until(lambda: "one" in bpy.data.objects)
        yield from until_idle()
        assert ("one" in bpy.data.objects) == confirm
    shown_is_decoded(active())


def check_a_bad_file_stops_nothing():
    yield from compressed(5)
    folder = written("bad.npmesh", "good.npmesh")
    with in_viewport():
        bpy.ops.import_scene.npmesh("INVOKE_DEFAULT", directory=str(folder),
                                    files=[{"name": "bad.npmesh"}, {"name": "good.npmesh"}])
    yield from until_idle()
    assert "good" in bpy.data.objects and "bad" not in bpy.data.objects and not leftovers()


def check_opening_leaves_numba_to_the_worker():
    import sys

    yield from compressed(5)
    folder = written("one.npmesh")
    with in_viewport():
        bpy.ops.import_scene.npmesh("INVOKE_DEFAULT", filepath=str(folder / "one.npmesh"))
    yield from until(lambda: "one" in bpy.data.objects)
    assert "numba" not in sys.modules


def check_the_panels_button_cancels():
    fresh_object(8)
    start_compressing()
    yield 1.0
    assert module("jobs").running(), "the job ended too soon to be cancelled"
    start = time.perf_counter()
    bpy.ops.object.npmesh_cancel()
    took = time.perf_counter() - start
    yield 0.3
    assert took < 0.5 and not module("jobs").running() and not leftovers()
    assert len(bpy.data.objects) == 1 and not bpy.data.objects[0].npmesh.is_preview
    say(f"  cancelled after {1000 * took:.0f} ms")


def check_escape_cancels():
    if shutil.which("xdotool") is None:
        say("  not run: no xdotool")
        return
    fresh_object(8)
    yield 1.0
    redraw = yield from redraw_stall()
    start_compressing()
    yield 1.0
    assert module("jobs").running(), "the job ended too soon to be cancelled"
    subprocess.run(["xdotool", "mousemove", "500", "500", "key", "Escape"], check=True)
    start = time.perf_counter()
    while module("jobs").running() and time.perf_counter() < start + 5:
        yield 0.01
    took = time.perf_counter() - start
    assert took < 0.5 + 2 * redraw, f"cancelling took {took:.2f} s"  # moving the mouse and the key may each draw
    yield 0.2
    say(f"  cancelled {1000 * took:.0f} ms after the key (redrawing alone: {1000 * redraw:.0f} ms)")
    assert not leftovers() and len(bpy.data.objects) == 1 and "npmesh_stream" not in bpy.data.objects[0]


def check_the_object_is_deleted_during_a_job():
    fresh_object(5)
    start_compressing()
    with in_viewport():
        bpy.ops.object.delete("EXEC_DEFAULT", True)
    yield from until_idle()
    assert not bpy.data.objects and not leftovers()


def check_the_object_is_renamed_and_edited_during_a_job():
    obj = fresh_object(5)
    start_compressing()
    obj.name = "Renamed"
    with in_viewport():
        bpy.ops.object.mode_set(mode="EDIT")
    yield from until_idle()
    assert obj.mode == "EDIT" and not obj.hide_get() and len(bpy.data.objects) == 1
    with in_viewport():
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.ops.object.npmesh_preview()
    assert active().npmesh.source == obj
    shown_is_decoded(active())


def check_another_file_is_opened_during_a_job():
    fresh_object(8)
    start_compressing()
    yield 0.5
    with in_viewport():
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    yield 0.5
    assert not module("jobs").running() and not leftovers()
    with in_viewport():
        bpy.ops.wm.read_homefile(use_factory_startup=True)
    yield 1.0


def check_disabling_during_a_job():
    import addon_utils

    fresh_object(8)
    start_compressing()
    yield 0.7
    jobs = module("jobs")
    addon_utils.disable(PACKAGE)
    yield 0.3
    assert not jobs.running() and not leftovers()
    addon_utils.enable(PACKAGE, default_set=True)
    assert bpy.ops.object.npmesh_compress.poll
