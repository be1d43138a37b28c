"""What the panels share: their place in the sidebar, wrapped lines, numbers as text."""
import textwrap

import bpy


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
