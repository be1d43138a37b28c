"""Setting up a window for a picture: the extension enabled, one object, the sidebar on the tab Progressive.

Scripts here run inside a Blender with a window, from the project's root:
blender --factory-startup --python docs/shots/NAME.py
"""
import importlib
import os
import sys
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
from mathutils import Euler, Vector

ROOT = Path(os.environ.get("NPM_ROOT", Path.cwd()))
FOLDER = ROOT / "out" / "shots"
sys.path.insert(0, str(ROOT))

from tests.addon import source_addon  # noqa: E402 - found in ROOT

FIRST_DRAW_SECONDS = 1.0  # the sidebar's tabs exist once it has been drawn
SIDEBAR, DISTANCE = 0.12, 0.95  # how far the view's centre is off, and its distance, in widths of what is shown
FRONT_RIGHT = Euler((1.38, 0.0, 0.5)).to_quaternion()  # from a little above, on an object that faces -y


def prepare(then: Callable[[], None]) -> None:
    """Enable the extension, tidy the window, call `then` in the context of the viewport, show the sidebar's tab."""
    bpy.context.preferences.view.show_splash = False
    source_addon.enable(ROOT)

    def start() -> None:
        space = viewport().spaces.active
        space.show_region_ui = True
        overlay, shading = space.overlay, space.shading
        overlay.show_floor = overlay.show_axis_x = overlay.show_axis_y = overlay.show_cursor = False
        overlay.show_outline_selected = overlay.show_object_origins = False
        shading.light, shading.studio_light, shading.show_cavity = "MATCAP", "clay_studio.exr", True
        region = next(r for r in viewport().regions if r.type == "WINDOW")
        with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=viewport(), region=region):
            then()
        bpy.app.timers.register(show_tab, first_interval=FIRST_DRAW_SECONDS)

    bpy.app.timers.register(start, first_interval=FIRST_DRAW_SECONDS)


def viewport() -> bpy.types.Area:
    """The 3D viewport of the first window."""
    return next(a for a in bpy.context.window_manager.windows[0].screen.areas if a.type == "VIEW_3D")


def show_tab() -> None:
    """Bring the sidebar's tab Progressive to the front."""
    next(r for r in viewport().regions if r.type == "UI").active_panel_category = "Progressive"
    viewport().tag_redraw()


def add_sculpt() -> bpy.types.Object:
    """The sculpt with its stream from out/shots (see prepare.py) as the only object, selected and active."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    bridge, preview, received = (importlib.import_module(f"{source_addon.MODULE}.{name}")
                                 for name in ("bridge", "preview", "core.received"))
    mesh = bpy.data.meshes.new("Sculpt")
    with np.load(FOLDER / "sculpt.npz", allow_pickle=False) as arrays:
        bridge.build(mesh, arrays["V"], arrays["F"])
    obj = bpy.data.objects.new("Sculpt", mesh)
    stream = [(FOLDER / name).read_bytes() for name in ("sculpt.npmesh", "sculpt.arrays")]
    preview.pack(obj, received.Received(*stream))
    bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    return obj


def frame(objects: list[bpy.types.Object]) -> None:
    """Look at `objects` from their front right, so that they fill the part beside the sidebar."""
    bpy.context.view_layer.update()
    corners = np.array([obj.matrix_world @ Vector(corner) for obj in objects for corner in obj.bound_box])
    sideways = corners @ np.array(FRONT_RIGHT @ Vector((1, 0, 0)))
    view = viewport().spaces.active.region_3d
    view.view_rotation, view.view_perspective = FRONT_RIGHT, "PERSP"
    size = np.ptp(sideways)
    view.view_location = Vector((corners.min(0) + corners.max(0)) / 2) + FRONT_RIGHT @ Vector((SIDEBAR * size, 0, 0))
    view.view_distance = DISTANCE * size
