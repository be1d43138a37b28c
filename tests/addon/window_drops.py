"""Checks of files dragged from another program onto the window; see run_in_window.py."""
import importlib.util
import os
import subprocess
import sys
from collections.abc import Callable, Generator
from functools import wraps
from pathlib import Path

import bpy

from .window_driver import (
    Check,
    active,
    compressed,
    fresh_object,
    in_viewport,
    leftovers,
    module,
    say,
    shown_is_decoded,
    until,
    until_idle,
)
from .window_jobs import written

_compressed: list[bytes] = []  # the one stream, once it is made


def with_drops(check: Callable[[], Check]) -> Callable[[], Check]:
    """A check that is reported as not run where nothing can be dropped."""
    @wraps(check)
    def checked() -> Check:
        if importlib.util.find_spec("Xlib") is None:
            say("  not run: no python-xlib")
        elif not os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
            say("  not run: no X display")
        else:
            yield from check()
    return checked


def streams(*names: str) -> Generator[float, None, Path]:
    """A folder of `written` streams, beside a scene of one object; compresses once for all checks."""
    if not _compressed:
        yield from compressed(5)
        _compressed.append(active()["npmesh_stream"])
    fresh_object(2)
    return written(*names, data=_compressed[0])


def drop(*paths: Path, on: str = "VIEW_3D") -> Check:
    """Let another program drop files on the middle of an area of this type, and wait until they are opened."""
    window = bpy.context.window_manager.windows[0]
    area = next(a for a in window.screen.areas if a.type == on)
    x, y = window.x + area.x + area.width // 2, window.y + area.y + area.height // 2
    script = Path(__file__).with_name("xdnd_source.py")
    source = subprocess.Popen([sys.executable, script, str(x), str(y), *paths], stderr=subprocess.PIPE, text=True)
    yield from until(lambda: source.poll() is not None)
    assert source.returncode == 0, source.stderr.read()
    yield 0.2  # Blender has thanked for the files, and calls the operator next
    yield from until_idle()


def reported() -> list[str]:
    """All that Blender has reported, a line each, as its Info editor shows it."""
    manager = bpy.context.window_manager
    window, clipboard = manager.windows[0], manager.clipboard
    area = next(a for a in window.screen.areas if a.ui_type == "TIMELINE")
    area.type = "INFO"
    try:
        region = next(r for r in area.regions if r.type == "WINDOW")
        with bpy.context.temp_override(window=window, area=area, region=region):
            bpy.ops.info.select_all(action="SELECT")
            bpy.ops.info.report_copy()
        return manager.clipboard.splitlines()
    finally:
        area.ui_type, manager.clipboard = "TIMELINE", clipboard


@with_drops
def check_a_dropped_file_opens():
    name = "with a space, ä and 100%"
    folder = yield from streams(f"{name}.npmesh")
    before = reported()
    yield from drop(folder / f"{name}.npmesh")
    assert active().name == name and active().npmesh.is_preview and active().select_get() and reported() == before
    shown_is_decoded(active())
    with in_viewport():
        bpy.ops.ed.undo()
    yield 0.3
    assert name not in bpy.data.objects, "undo leaves the opened file"


@with_drops
def check_several_files_dropped_on_the_outliner():
    folder = yield from streams("one.npmesh", "two.npmesh", "THREE.NPMESH")
    yield from drop(*folder.iterdir(), on="OUTLINER")
    opened = bpy.context.selected_objects
    assert {o.name for o in opened} == {"one", "two", "THREE"}, opened
    for obj in opened:
        shown_is_decoded(obj)


@with_drops
def check_a_dropped_file_that_was_cut_off():
    folder = yield from streams("cut.npmesh")
    before = reported()
    yield from drop(folder / "cut.npmesh")
    state = active().npmesh
    assert active().name == "cut" and 0 < state.arrived_features < state.total_features
    shown_is_decoded(active())
    line, = reported()[len(before):]
    assert line == (f"'cut.npmesh' ends early: opened with {state.arrived_features:,} of "
                    f"{state.total_features:,} features"), line


@with_drops
def check_a_dropped_file_that_is_no_stream():
    folder = yield from streams()
    path = folder / "picture.npmesh"
    path.write_bytes(b"\x89PNG\r\n\x1a\n" * 300)
    scene, before = list(bpy.data.objects), reported()
    meshes, selected = len(bpy.data.meshes), bpy.context.selected_objects
    yield from drop(path)
    line, = reported()[len(before):]
    assert line.startswith("'picture.npmesh': Expected an .npmesh stream, found ") and "another kind of file" in line, line
    assert list(bpy.data.objects) == scene and len(bpy.data.meshes) == meshes and not leftovers()
    assert bpy.context.selected_objects == selected


@with_drops
def check_a_drop_in_edit_mode_says_why_not():
    folder = yield from streams("one.npmesh")
    obj = active()
    with in_viewport():
        bpy.ops.object.mode_set(mode="EDIT")
    before = reported()
    yield from drop(folder / "one.npmesh")
    assert obj.mode == "EDIT" and "one" not in bpy.data.objects and not module("jobs").running()
    line, = reported()[len(before):]
    assert line == "Expected Object Mode, found another; leave that mode first", line
    with in_viewport():
        bpy.ops.object.mode_set(mode="OBJECT")
    yield 0.1
