"""docs/images/panel.png: a sculpt and, beside it, the preview of its stream, with the sidebar that controls it."""
import os
import sys
from pathlib import Path

import bpy
from mathutils import Vector

sys.path.insert(0, str(Path(os.environ.get("NPM_ROOT", Path.cwd())) / "docs" / "shots"))

import window  # noqa: E402 - beside this file

FEATURES = 5000
APART = 2.7  # Blender units between the two


def preview() -> None:
    """Show a part of the sculpt's features, and the sculpt itself on its left."""
    obj = window.add_sculpt()
    bpy.ops.object.npmesh_preview()
    shown = bpy.context.view_layer.objects.active
    shown.npmesh.features = FEATURES
    original = bpy.data.objects.new("Original", obj.data)
    bpy.context.collection.objects.link(original)
    right = window.FRONT_RIGHT @ Vector((1, 0, 0))
    shown.location += APART / 2 * right
    original.location -= APART / 2 * right
    window.frame([original, shown])


window.prepare(preview)
