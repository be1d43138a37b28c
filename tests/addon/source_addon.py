"""Enables the extension from this source tree, in any Blender, under the name that an installed one has.

An extension repository is added whose folder holds a link to `npm_blender`; so relative imports, preferences and the
worker process meet the same package name (bl_ext.<repository>.npm_blender) as in a user's Blender. The folder stays the
same, as compiled code is kept by path. Preferences are not saved.
"""
from pathlib import Path

import addon_utils
import bpy

ROOT = Path(__file__).resolve().parents[2]
REPOSITORY = "npm_source"
MODULE = f"bl_ext.{REPOSITORY}.npm_blender"


def enable(root: Path = ROOT) -> str:
    """Enable the extension found in `root` and return its module name. Raises RuntimeError if it does not enable."""
    folder = root / "build" / REPOSITORY
    folder.mkdir(parents=True, exist_ok=True)
    link = folder / "npm_blender"
    if not link.is_symlink():
        link.symlink_to(Path("..", "..", "npm_blender"), target_is_directory=True)
    bpy.context.preferences.extensions.repos.new(name="Source Tree", module=REPOSITORY, custom_directory=str(folder))
    addon_utils.extensions_refresh()
    if addon_utils.enable(MODULE, default_set=True) is None:
        raise RuntimeError(f"Expected {MODULE} to be enabled, found an error; see the lines above")
    return MODULE
