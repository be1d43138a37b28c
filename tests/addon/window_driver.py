"""Drives checks in a Blender with a window: generators that `yield seconds` to let the window live on.

Watches for how long the window stands still, and for anything that Python writes to the console meanwhile.
"""
import importlib
import io
import os
import sys
import time
import traceback
from collections.abc import Callable, Generator
from pathlib import Path

import bpy
import numpy as np

from . import source_addon

ROOT = Path(os.environ.get("NPM_ROOT", Path.cwd()))
PACKAGE = source_addon.enable(ROOT)
TICK_SECONDS = 0.01
STALL_SECONDS = 0.06  # of the window's own thread, beyond drawing, are what a user may notice
Check = Generator[float, None, None]
gaps: list[float] = []  # seconds between two ticks, beyond TICK_SECONDS, since someone cleared it
busy: list[float] = []  # seconds of the window's own thread between two ticks, whatever else keeps the cores busy
_last_tick = [0.0, 0.0]


class _Console(io.TextIOBase):
    """Standard error that also remembers what was written."""

    def __init__(self) -> None:
        self.heard = ""

    def write(self, text: str) -> int:
        self.heard += text
        return sys.__stderr__.write(text)

    def flush(self) -> None:
        sys.__stderr__.flush()


def say(line: str) -> None:
    """One line on standard output, at once."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def module(name: str):
    """A module of the enabled extension."""
    return importlib.import_module(f"{PACKAGE}.{name}")


def in_viewport():
    """The context of the window's viewport."""
    window = bpy.context.window_manager.windows[0]
    area = next(a for a in window.screen.areas if a.type == "VIEW_3D")
    region = next(r for r in area.regions if r.type == "WINDOW")
    return bpy.context.temp_override(window=window, area=area, region=region)


def active() -> bpy.types.Object:
    """The active object."""
    return bpy.context.view_layer.objects.active


def fresh_object(subdivisions: int) -> bpy.types.Object:
    """An empty scene with one ico sphere of 20 * 4**(subdivisions - 1) faces."""
    with in_viewport():
        if bpy.context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        for obj in list(bpy.data.objects):
            bpy.data.objects.remove(obj)
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions)
        obj = bpy.context.active_object
        obj.npmesh.base_faces, obj.npmesh.levels = 80, 2
        bpy.ops.ed.undo_push(message="Test Object")
    return obj


def until(condition: Callable[[], object], limit: float = 120) -> Check:
    """Wait until `condition` holds; fails the check after `limit` seconds."""
    deadline = time.monotonic() + limit
    while not condition():
        assert time.monotonic() < deadline, "what the check waits for does not happen"
        yield 0.05
    yield 0.1


def until_idle() -> Check:
    """Wait for the running jobs to end and for what follows."""
    yield from until(lambda: not module("jobs").running() and not modal_operators())
    yield 0.3


def modal_operators() -> list[str]:
    """Our operators that still run, in all windows: they hand out results in steps after their job has ended."""
    windows = bpy.context.window_manager.windows
    return [op.bl_idname for window in windows for op in window.modal_operators if "npmesh" in op.bl_idname.lower()]


def shown() -> Check:
    """Wait for what the previews have still to show."""
    yield 0.1
    yield from until(lambda: not module("preview").is_busy())


def compressed(subdivisions: int) -> Check:
    """Compress a fresh object as the button does, and wait for the preview, which is active then."""
    fresh_object(subdivisions)
    start_compressing()
    yield from until_idle()
    assert active().npmesh.is_preview


def start_compressing() -> None:
    """Press the button."""
    with in_viewport():
        assert bpy.ops.object.npmesh_compress("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    assert module("jobs").running()


def redraw_stall() -> Generator[float, None, float]:
    """The longest stall while the window only draws, in seconds: what software rendering costs here."""
    gaps.clear()
    for _ in range(10):
        with in_viewport():
            bpy.context.area.tag_redraw()
        yield 0.1
    return max(gaps)


def leftovers() -> list[str]:
    """Folders of jobs that have not been removed."""
    return [name for name in os.listdir(bpy.app.tempdir) if name.startswith("npmesh_")]


def shown_is_decoded(obj: bpy.types.Object) -> None:
    """Fail unless the mesh of the preview is exactly what its stream decodes to."""
    V = np.zeros((len(obj.data.vertices), 3), dtype=np.float32)
    obj.data.vertices.foreach_get("co", V.reshape(-1))
    received = module("core.codec.stored_stream").StoredStream(obj["npmesh_stream"], obj["npmesh_arrays"])
    mesh = received.open().decode(features=obj.npmesh.features, level=int(obj.npmesh.level))
    assert np.array_equal(V, mesh.V.astype(np.float32)), "the mesh is not what the stream decodes to"


def _everything(checks: list[Callable[[], Check]], console: _Console) -> Check:
    yield 2.0
    with in_viewport():
        bpy.context.space_data.overlay.show_overlays = False  # drawn in software here, they cost more than the mesh
    failed = 0
    for check in checks:
        say(f"{check.__name__} ...")
        console.heard = ""
        try:
            yield from check()
            assert "Error" not in console.heard and "Traceback" not in console.heard, "the console shows an error"
        except Exception:
            failed += 1
            traceback.print_exc()
            module("jobs").cancel_all()
            yield 0.5
    say(f"window checks: {len(checks)} run, {failed} failed")
    if failed:
        sys.stdout.flush()
        os._exit(1)  # Blender itself always ends with 0
    bpy.ops.wm.quit_blender()


def run(checks: list[Callable[[], Check]]) -> None:
    """Run all checks one after the other from Blender's timers, then quit; exit code 1 if one failed."""
    console = sys.stderr = _Console()
    steps = _everything(checks, console)
    resume_at = [0.0]
    _last_tick[:] = time.perf_counter(), time.thread_time()

    def tick():
        now = time.perf_counter()
        gaps.append(now - _last_tick[0] - TICK_SECONDS)
        busy.append(time.thread_time() - _last_tick[1])
        if now >= resume_at[0]:
            wait = next(steps, None)
            if wait is None:
                return None
            resume_at[0] = time.perf_counter() + wait
        _last_tick[:] = time.perf_counter(), time.thread_time()
        return TICK_SECONDS

    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.view.filebrowser_display_type = "SCREEN"
    bpy.app.timers.register(tick, first_interval=1.0, persistent=True)
