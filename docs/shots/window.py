"""Setting up a window for a picture: the extension enabled, one 3D viewport, its sidebar on the tab Progressive."""
import bpy

from tests.addon import source_addon

FIRST_DRAW_SECONDS = 0.5  # the sidebar's tabs exist once it has been drawn


def viewport() -> tuple[bpy.types.Window, bpy.types.Area]:
    """The first window and its 3D viewport."""
    window = bpy.context.window_manager.windows[0]
    return window, next(area for area in window.screen.areas if area.type == "VIEW_3D")


def prepare(then, **enable_options) -> None:
    """Enable the extension, empty the scene, and call `then()` once the window is drawn with its sidebar open.

    `then` runs with the viewport as context.
    """
    bpy.context.preferences.view.show_splash = False
    source_addon.enable(**enable_options)
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)

    def start() -> None:
        window, area = viewport()
        space = area.spaces.active
        space.show_region_ui = True
        space.overlay.show_floor = space.overlay.show_axis_x = space.overlay.show_axis_y = False
        space.overlay.show_outline_selected = False
        space.shading.light, space.shading.studio_light = "MATCAP", "clay_studio.exr"
        space.shading.show_cavity = True
        region = next(r for r in area.regions if r.type == "WINDOW")
        with bpy.context.temp_override(window=window, area=area, region=region):
            then()
        bpy.app.timers.register(show_tab, first_interval=FIRST_DRAW_SECONDS)

    bpy.app.timers.register(start, first_interval=FIRST_DRAW_SECONDS)


def show_tab() -> None:
    """Bring the sidebar's tab Progressive to the front."""
    _, area = viewport()
    sidebar = next(r for r in area.regions if r.type == "UI")
    sidebar.active_panel_category = "Progressive"
    area.tag_redraw()


def frame() -> None:
    """Look at the active object from its front right, filling the viewport."""
    _, area = viewport()
    area.spaces.active.region_3d.view_rotation = (0.78, 0.47, 0.21, 0.35)
    bpy.ops.view3d.view_selected(use_all_regions=True)
