"""docs/images/panel.png: a compressed sculpt in its preview, with the sidebar that controls it."""
import os
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(os.environ.get("NPM_ROOT", Path.cwd())) / "docs" / "shots"))

import window  # noqa: E402 - beside this file

FEATURES = 2000


def compress() -> None:
    """Compress the sculpt and show a part of its features."""
    window.add_sculpt()
    bpy.ops.object.npmesh_compress()
    bpy.context.view_layer.objects.active.npmesh.features = FEATURES
    window.frame()


window.prepare(compress)
