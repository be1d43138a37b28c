"""Setting up a window for a picture: the extension enabled, one object, the sidebar on the tab Progressive.

Scripts here run inside a Blender with a window, from the project's root:
blender --factory-startup --python docs/shots/NAME.py
"""
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
from mathutils import Euler

ROOT = Path(os.environ.get("NPM_ROOT", Path.cwd()))
sys.path.insert(0, str(ROOT))

from tests.addon import source_addon  # noqa: E402 - found in ROOT

FIRST_DRAW_SECONDS = 1.0  # the sidebar's tabs exist once it has been drawn
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
    """The sculpt of the demo as the only object, selected and active. Made by a second Blender: it resets its own."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    path = Path(bpy.app.tempdir, "sculpt.npz")
    code = (f"import sys; sys.path.insert(0, {str(ROOT)!r}); import numpy; from npm_blender.demo import sculpt; "
            f"mesh = sculpt.make_sculpt(); numpy.savez({str(path)!r}, V=mesh.V, F=mesh.F)")
    subprocess.run([bpy.app.binary_path, "-b", "--factory-startup", "--python-expr", code], check=True)
    mesh = bpy.data.meshes.new("Sculpt")
    with np.load(path, allow_pickle=False) as arrays:
        mesh.from_pydata(arrays["V"].astype(np.float32), [], arrays["F"])
    mesh.shade_smooth()
    obj = bpy.data.objects.new("Sculpt", mesh)
    bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    return obj


def frame() -> None:
    """Look at the active object from its front right, so that it fills the part beside the sidebar."""
    view = viewport().spaces.active.region_3d
    view.view_rotation = FRONT_RIGHT
    view.view_perspective = "PERSP"
    bpy.ops.view3d.view_selected()
