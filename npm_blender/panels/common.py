"""What the panels share: their place in the sidebar, wrapped lines, numbers as text."""
import textwrap

import bpy

ICON_PIXELS = 16


class Sidebar:
    """The tab Progressive in the sidebar of the 3D viewport."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Progressive"


def lines(layout: bpy.types.UILayout, text: str, icon: str, width: int, alert: bool = False) -> None:
    """Text broken into as many labels as the panel's width in pixels needs."""
    column = layout.column(align=True)
    column.alert = alert
    letters = max(int(width / (7.2 * bpy.context.preferences.system.ui_scale)) - 6, 16)
    for k, line in enumerate(textwrap.wrap(text, letters)):
        column.label(text=line, icon="BLANK1" if k else icon)


def size_text(size: int) -> str:
    """A number of bytes with the unit that a file manager would show (1 kB = 1000 bytes)."""
    for unit, scale in (("MB", 1e6), ("kB", 1e3)):
        if size >= scale:
            return f"{size / scale:.1f} {unit}"
    return f"{size} bytes"


def percent_text(size: int, whole: int) -> str:
    """A share with two digits that count."""
    share = 100 * size / max(whole, 1)
    return f"{share:.0f}%" if share >= 10 else f"{share:.1f}%" if share >= 1 else f"{share:.2f}%"


def short_count(count: int) -> str:
    """A count in a few letters, as 25.6k."""
    for unit, scale in (("M", 1e6), ("k", 1e3)):
        if count >= scale:
            text = f"{count / scale:.1f}"
            return text.removesuffix(".0") + unit
    return str(count)


def length_text(length: float, scene: bpy.types.Scene) -> str:
    """A length in Blender units with three digits that count, in the scene's system of units."""
    units = scene.unit_settings
    if units.system == "NONE" or length == 0:  # Blender's function ends Blender without a system (4.3, 4.5, 5.2)
        return f"{length:.3g}"
    return bpy.utils.units.to_string(units.system, "LENGTH", length * units.scale_length, precision=3)


_icons: list = []  # one collection of Blender's, made when the first icon is drawn


def icon_of(colour: tuple[float, float, float]) -> int:
    """Number of an icon that is filled with a colour (sRGB)."""
    import bpy.utils.previews

    if not _icons:
        _icons.append(bpy.utils.previews.new())
    name = "".join(f"{round(255 * channel):02x}" for channel in colour)
    if name not in _icons[0]:
        icon = _icons[0].new(name)
        icon.icon_size = (ICON_PIXELS, ICON_PIXELS)
        icon.icon_pixels_float[:] = [*colour, 1.0] * ICON_PIXELS**2
    return _icons[0][name].icon_id


def remove_icons() -> None:
    """Give the icons back, when the extension is being disabled."""
    import bpy.utils.previews

    while _icons:
        bpy.utils.previews.remove(_icons.pop())
