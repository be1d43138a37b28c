"""Pictures of a window: the extension enabled, the sidebar on the tab Progressive, the screen saved with what to keep of it.

For scripts that run inside a Blender with a window, from the project's root; see make.py.
"""
import importlib
import json
import os
import shutil
import subprocess
import sys
import time
import traceback
from collections.abc import Callable, Generator, Sequence
from pathlib import Path

import bpy
import numpy as np
from mathutils import Euler, Quaternion, Vector

ROOT = Path(os.environ.get("NPM_ROOT", Path.cwd()))
FOLDER = ROOT / "out" / "shots"
sys.path.insert(0, str(ROOT))

from tests.addon import source_addon  # noqa: E402 - found in ROOT

FIRST_DRAW_SECONDS = 2.0  # the sidebar's tabs exist once it has been drawn
DRAW_SECONDS = 1.0  # from the drawing of the viewport to that of everything else, in software
LIMIT_SECONDS = 400  # for anything that is waited for
SIDEBAR, DISTANCE = 0.12, 0.95  # how far the view's centre is off, and its distance, in widths of what is shown
FRONT_RIGHT = Euler((1.38, 0.0, 0.5)).to_quaternion()  # from a little above, on an object that faces -y
FRONT = Euler((1.45, 0.0, 0.0)).to_quaternion()
Picture = Generator[float, None, None]


def module(name: str):
    """A module of the enabled extension."""
    return importlib.import_module(f"{source_addon.MODULE}.{name}")


def take(pictures: Sequence[Callable[[], Picture]]) -> None:
    """Enable the extension, tidy the window, take one picture after the other, then quit; exit code 1 if one fails."""
    bpy.context.preferences.view.show_splash = False
    source_addon.enable(ROOT)
    steps = _all(pictures)

    def tick() -> float | None:
        try:
            return next(steps)
        except StopIteration:
            bpy.ops.wm.quit_blender()
        except Exception:
            traceback.print_exc()
            module("jobs").cancel_all()
            sys.stderr.flush()
            os._exit(1)  # Blender itself always ends with 0
        return None

    bpy.app.timers.register(tick, first_interval=FIRST_DRAW_SECONDS, persistent=True)


def _all(pictures: Sequence[Callable[[], Picture]]) -> Picture:
    space = viewport().spaces.active
    space.show_region_ui, space.show_region_toolbar, space.show_gizmo = True, False, False
    overlay, shading = space.overlay, space.shading
    overlay.show_floor = overlay.show_axis_x = overlay.show_axis_y = overlay.show_cursor = overlay.show_text = False
    overlay.show_outline_selected = overlay.show_object_origins = False
    shading.light, shading.studio_light, shading.show_cavity = "MATCAP", "clay_studio.exr", True
    yield FIRST_DRAW_SECONDS
    region("UI").active_panel_category = "Progressive"
    yield from drawn()
    for picture in pictures:
        yield from picture()


def viewport() -> bpy.types.Area:
    """The 3D viewport of the first window."""
    return next(a for a in bpy.context.window_manager.windows[0].screen.areas if a.type == "VIEW_3D")


def region(kind: str) -> bpy.types.Region:
    """A region of the viewport."""
    return next(r for r in viewport().regions if r.type == kind)


def in_viewport():
    """The context of the viewport."""
    return bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=viewport(),
                                     region=region("WINDOW"))


def until(condition: Callable[[], object]) -> Picture:
    """Wait until `condition` holds. Raises TimeoutError."""
    end = time.monotonic() + LIMIT_SECONDS
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError("what the picture waits for does not happen")
        yield 0.05


def drawn() -> Picture:
    """Wait until what has changed is on the screen."""
    draws = []
    handle = bpy.types.SpaceView3D.draw_handler_add(lambda: draws.append(1), (), "WINDOW", "POST_PIXEL")
    try:
        for k in (1, 2):
            for area in bpy.context.window_manager.windows[0].screen.areas:
                area.tag_redraw()
            yield from until(lambda k=k: len(draws) >= k)
            yield DRAW_SECONDS
    finally:
        bpy.types.SpaceView3D.draw_handler_remove(handle, "WINDOW")


def save(name: str, part: str = "screen") -> None:
    """The screen as out/shots/NAME.png, and in NAME.json the box to keep of it: "screen", "sidebar" or "view"."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    path = FOLDER / f"{name}.png"
    if shutil.which("import") and os.environ.get("DISPLAY"):  # ImageMagick: Blender's own is black on a virtual screen
        subprocess.run(["import", "-window", "root", str(path)], check=True)
    else:
        bpy.ops.screen.screenshot(filepath=str(path))
    (FOLDER / f"{name}.json").write_text(json.dumps(_box(part)))


def _box(part: str) -> list[int]:
    """Left, top, right and bottom in pixels of the screen, whose origin is on top."""
    height = bpy.context.window_manager.windows[0].height
    area, bar, view = viewport(), region("UI"), region("WINDOW")
    if part == "sidebar":
        return [bar.x, height - bar.y - bar.height, bar.x + bar.width, height - bar.y]
    if part == "view":  # beside the sidebar, below the header
        header = region("HEADER").height + region("TOOL_HEADER").height
        return [view.x, height - area.y - area.height + header, bar.x, height - area.y]
    return [0, 0, bpy.context.window_manager.windows[0].width, height]


def clear() -> None:
    """Remove all objects."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)


def add_sculpt(compressed: bool) -> bpy.types.Object:
    """The sculpt from out/shots (see prepare.py), with its stream or without, as the only object, selected and active."""
    clear()
    mesh = bpy.data.meshes.new("Sculpt")
    with np.load(FOLDER / "sculpt.npz", allow_pickle=False) as arrays:
        module("bridge").build(mesh, arrays["V"], arrays["F"])
    obj = bpy.data.objects.new("Sculpt", mesh)
    if compressed:
        data, arrays = ((FOLDER / f"sculpt.{suffix}").read_bytes() for suffix in ("npmesh", "arrays"))
        measured = (FOLDER / "sculpt.measured").read_text(encoding="utf-8")
        module("preview").pack(obj, module("core.codec").StoredStream(data, arrays, measured))
    bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    return obj


def frame(objects: Sequence[bpy.types.Object], distance: float = DISTANCE, side: float = SIDEBAR,
          look: Quaternion = FRONT_RIGHT) -> None:
    """Look at `objects`, so that they fill the part beside the sidebar: from `distance` widths, `side` widths aside."""
    bpy.context.view_layer.update()
    corners = np.array([obj.matrix_world @ Vector(corner) for obj in objects for corner in obj.bound_box])
    sideways = corners @ np.array(look @ Vector((1, 0, 0)))
    view = viewport().spaces.active.region_3d
    view.view_rotation, view.view_perspective = look, "PERSP"
    size = np.ptp(sideways)
    view.view_location = Vector((corners.min(0) + corners.max(0)) / 2) + look @ Vector((side * size, 0, 0))
    view.view_distance = distance * size
