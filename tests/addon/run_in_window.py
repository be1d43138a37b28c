"""What only a window can show: the modal operator, cancelling, undo and redo. Run by Blender with a window:

    blender --factory-startup --python tests/addon/run_in_window.py

Prints one line for each check, then how many failed. Checks are generators: `yield seconds` lets the window live on.
The Escape key is pressed with xdotool; without it, that check is reported as not run.
"""
import os
import shutil
import subprocess
import sys
import time
import traceback
from pathlib import Path

import bpy
import numpy as np

ROOT = Path(os.environ.get("NPM_ROOT", Path.cwd()))
sys.path.insert(0, str(ROOT))

from tests.addon import source_addon  # noqa: E402 - found in ROOT

PACKAGE = source_addon.enable(ROOT)
TICK_SECONDS = 0.01
_gaps: list[float] = []
_last_tick = [time.perf_counter()]


def say(line: str) -> None:
    """One line on standard output, at once."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def module(name: str):
    """A module of the enabled extension."""
    import importlib

    return importlib.import_module(f"{PACKAGE}.{name}")


def in_viewport():
    """The context of the window's viewport."""
    window = bpy.context.window_manager.windows[0]
    area = next(a for a in window.screen.areas if a.type == "VIEW_3D")
    region = next(r for r in area.regions if r.type == "WINDOW")
    return bpy.context.temp_override(window=window, area=area, region=region)


def fresh_object(subdivisions: int):
    """An empty scene with one ico sphere of 20 * 4**(subdivisions - 1) faces."""
    with in_viewport():
        for obj in list(bpy.data.objects):
            bpy.data.objects.remove(obj)
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions)
        obj = bpy.context.active_object
        obj.npmesh.base_faces, obj.npmesh.levels = 80, 2
        bpy.ops.ed.undo_push(message="Test Object")
    return obj


def until_idle(limit: float = 120):
    """Wait for the running job; yields."""
    deadline = time.monotonic() + limit
    while module("jobs").running():
        assert time.monotonic() < deadline, "the job does not end"
        yield 0.05
    yield 0.3


def redraw_stall():
    """The longest stall while the window only draws, in seconds: what software rendering costs here."""
    _gaps.clear()
    for _ in range(10):
        with in_viewport():
            bpy.context.area.tag_redraw()
        yield 0.1
    return max(_gaps)


def leftovers() -> list[str]:
    """Folders of jobs that have not been removed."""
    return [name for name in os.listdir(bpy.app.tempdir) if name.startswith("npmesh_")]


def shown_is_decoded(obj) -> None:
    """Fail unless the mesh of the preview is exactly what its stream decodes to."""
    V = np.zeros((len(obj.data.vertices), 3), dtype=np.float32)
    obj.data.vertices.foreach_get("co", V.reshape(-1))
    stream = module("core.codec").open_stream(obj["npmesh_stream"])
    mesh = stream.decode(features=obj.npmesh.features, level=int(obj.npmesh.level))
    assert np.array_equal(V, mesh.V.astype(np.float32)), "the mesh is not what the stream decodes to"


def check_compress_keeps_the_window_alive():
    name = fresh_object(7).name
    yield 1.0
    redraw = yield from redraw_stall()
    start = time.perf_counter()
    with in_viewport():
        assert bpy.ops.object.npmesh_compress("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    took = time.perf_counter() - start
    assert module("jobs").running()
    _gaps.clear()
    yield from until_idle()
    shown = bpy.context.view_layer.objects.active
    assert shown.npmesh.is_preview and shown.npmesh.source.name == name
    shown_is_decoded(shown)
    say(f"  starting took {1000 * took:.0f} ms, then the longest stall was {1000 * max(_gaps):.0f} ms "
          f"(redrawing alone: {1000 * redraw:.0f} ms)")


def check_undo_and_redo():
    fresh_object(5)
    with in_viewport():
        bpy.ops.object.npmesh_compress("INVOKE_DEFAULT")
    yield from until_idle()
    obj = bpy.context.view_layer.objects.active
    name = obj.name
    total = obj.npmesh.features
    for features, level in ((7, "2"), (total, "1"), (3, "0"), (20, "2")):
        obj.npmesh.features, obj.npmesh.level = features, level
        yield 0.2
        with in_viewport():
            bpy.ops.ed.undo_push(message="Slider")
    for features, level in ((3, "0"), (total, "1"), (7, "2"), (total, "2")):
        with in_viewport():
            bpy.ops.ed.undo()
        yield 0.2
        obj = bpy.data.objects[name]
        assert (obj.npmesh.features, obj.npmesh.level) == (features, level), "undo gives another state"
        shown_is_decoded(obj)
    with in_viewport():
        bpy.ops.ed.undo()
    yield 0.2
    assert name not in bpy.data.objects and not bpy.data.objects[0].hide_get(), "undo leaves the preview"
    for _ in range(5):
        with in_viewport():
            bpy.ops.ed.redo()
        yield 0.2
    obj = bpy.data.objects[name]
    assert (obj.npmesh.features, obj.npmesh.level) == (20, "2")
    shown_is_decoded(obj)


def check_dragging_the_slider():
    obj = bpy.context.view_layer.objects.active
    obj.npmesh.level = "2"
    took = []
    for k in range(40):
        start = time.perf_counter()
        obj.npmesh.detail = abs(20 - k) * 5
        took.append(time.perf_counter() - start)
        yield TICK_SECONDS
    yield 0.3
    shown_is_decoded(obj)
    took.sort()
    say(f"  setting the slider took {1000 * took[len(took) // 2]:.1f} ms, at most {1000 * took[-1]:.1f} ms")


def check_delete_and_discard():
    obj = bpy.context.view_layer.objects.active
    obj_name = obj.name
    with in_viewport():
        obj.npmesh.features = 2
        bpy.ops.ed.undo_push(message="Slider")
        bpy.ops.object.delete("EXEC_DEFAULT", True)  # True: with an undo step, as from the menu
        assert bpy.context.view_layer.objects.get(obj_name) is None
        bpy.ops.ed.undo()
    yield 0.3
    obj = next(o for o in bpy.data.objects if o.npmesh.is_preview)
    shown_is_decoded(obj)
    with in_viewport():
        bpy.context.view_layer.objects.active = obj
        bpy.ops.object.npmesh_discard()
    yield 0.3
    assert not any(o.npmesh.is_preview for o in bpy.data.objects)


def check_exporting_from_the_file_browser():
    bpy.context.preferences.view.filebrowser_display_type = "SCREEN"
    obj = fresh_object(5)
    path = Path(bpy.app.tempdir, "window.npmesh")
    for confirm in (False, True):
        with in_viewport():
            bpy.ops.export_scene.npmesh("INVOKE_DEFAULT", filepath=str(path))
        yield 1.5
        window = bpy.context.window_manager.windows[0]
        area = next(a for a in window.screen.areas if a.type == "FILE_BROWSER")
        region = next(r for r in area.regions if r.type == "WINDOW")
        with bpy.context.temp_override(window=window, area=area, region=region):
            bpy.ops.file.execute() if confirm else bpy.ops.file.cancel()
        yield 1.0
        yield from until_idle()
        assert path.exists() == confirm
    assert path.read_bytes() == obj["npmesh_stream"] and not obj.npmesh.is_preview


def check_the_panels_button_cancels():
    fresh_object(8)
    with in_viewport():
        bpy.ops.object.npmesh_compress("INVOKE_DEFAULT")
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
    with in_viewport():
        bpy.ops.object.npmesh_compress("INVOKE_DEFAULT")
    yield 1.0
    assert module("jobs").running(), "the job ended too soon to be cancelled"
    subprocess.run(["xdotool", "mousemove", "500", "500", "key", "Escape"], check=True)
    yield 0.6
    assert not module("jobs").running() and not leftovers()


def check_disabling_during_a_job():
    import addon_utils

    fresh_object(8)
    with in_viewport():
        bpy.ops.object.npmesh_compress("INVOKE_DEFAULT")
    yield 0.7
    jobs = module("jobs")
    addon_utils.disable(PACKAGE)
    yield 0.3
    assert not jobs.running() and not leftovers()
    addon_utils.enable(PACKAGE, default_set=True)
    assert bpy.ops.object.npmesh_compress.poll


CHECKS = [function for name, function in list(globals().items()) if name.startswith("check_")]


def everything():
    """Run all checks one after the other; yields what they yield."""
    yield 2.0
    with in_viewport():
        bpy.context.space_data.overlay.show_overlays = False  # drawn in software here, they cost more than the mesh
    failed = 0
    for check in CHECKS:
        say(f"{check.__name__} ...")
        try:
            yield from check()
        except Exception:
            failed += 1
            traceback.print_exc()
    say(f"window checks: {len(CHECKS)} run, {failed} failed")


def main() -> None:
    """Drive `everything` from Blender's timers, and watch for how long they are kept from running."""
    steps = everything()
    resume_at = [0.0]

    def tick():
        now = time.perf_counter()
        _gaps.append(now - _last_tick[0] - TICK_SECONDS)
        if now >= resume_at[0]:
            wait = next(steps, None)
            if wait is None:
                return None
            resume_at[0] = time.perf_counter() + wait
        _last_tick[0] = time.perf_counter()
        return TICK_SECONDS

    bpy.context.preferences.view.show_splash = False
    bpy.app.timers.register(tick, first_interval=1.0)


main()
