"""Sidebars drawn again; what solid viewports colour by: attributes while a deviation is shown, then what the user had chosen.

The choice is kept on the screen, which is saved with the .blend and, like the shading itself, not undone.
"""
import json

import bpy

KEY = "npmesh_color_type"  # custom property of a screen: JSON, number of the area to its colour before
ATTRIBUTE = "VERTEX"  # Blender's word for colouring by the active attribute


def sync() -> bool:
    """Make the viewports follow: attributes if any preview shows its deviation. Returns whether one does."""
    shown = any(o.npmesh.is_preview and o.npmesh.show_deviation for scene in bpy.data.scenes for o in scene.objects)
    for screen in bpy.data.screens:
        if shown:
            _switch(screen)
        elif KEY in screen:
            _restore(screen)
    return shown


def restore_viewports() -> None:
    """Give every viewport back what the user had chosen: the extension is being disabled."""
    for screen in bpy.data.screens:
        if KEY in screen:
            _restore(screen)


def redraw_panels() -> None:
    """Draw the sidebars again; not the viewports, which may take long."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            for region in area.regions:
                if area.type == "VIEW_3D" and region.type == "UI":
                    region.tag_redraw()


def _spaces(screen: bpy.types.Screen) -> dict[str, bpy.types.SpaceView3D]:
    return {str(k): space for k, area in enumerate(screen.areas) for space in area.spaces if space.type == "VIEW_3D"}


def _switch(screen: bpy.types.Screen) -> None:
    """Colour by attribute where that was not done before; a user who chooses otherwise meanwhile is left alone."""
    before = _known(screen)
    for name, space in _spaces(screen).items():
        if name not in before:
            before[name] = space.shading.color_type
            space.shading.color_type = ATTRIBUTE
    if before != _known(screen):
        screen[KEY] = json.dumps(before)


def _restore(screen: bpy.types.Screen) -> None:
    before = _known(screen)
    for name, space in _spaces(screen).items():
        if name in before and space.shading.color_type == ATTRIBUTE:
            try:
                space.shading.color_type = before[name]
            except TypeError:
                pass  # not a colour that this Blender has
    del screen[KEY]


def _known(screen: bpy.types.Screen) -> dict[str, str]:
    try:
        before = json.loads(screen.get(KEY, "{}"))
    except (ValueError, TypeError):
        return {}
    return before if isinstance(before, dict) else {}
