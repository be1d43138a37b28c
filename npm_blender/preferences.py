"""Preferences > Add-ons: threads, the cache, and which packages are there.

Everything here is about the worker process; `worker_settings` is how it gets there. Nothing is downloaded: what is
missing is named, with what to do about it.
"""
import time
from functools import lru_cache
from pathlib import Path

import bpy
from bpy.props import IntProperty, StringProperty

from .jobs import WorkerSettings
from .runtime import caches, packages

SIZE_SECONDS = 2.0  # the size of the cache is counted again after so long, while it is drawn


class NpmPreferences(bpy.types.AddonPreferences):
    """What every compressing uses; settings of one object are the object's."""

    bl_idname = __package__

    threads: IntProperty(
        name="Threads", default=0, min=0, max=256, soft_max=32,
        description="Processor threads of a job, for the steps that use several. With 0, these take all cores, up to eight. "
                    "Blender's window goes first in any case")
    cache: StringProperty(
        name="Cache Folder", subtype="DIR_PATH",
        description="Where compiled code and remeshed surfaces are kept, so that they need not be made again. Empty for "
                    "Blender's folder for this extension")
    checked: StringProperty(options={"HIDDEN", "SKIP_SAVE"}, description="What the last check of the packages found")

    def draw(self, context):
        """Called by Blender for the extension's entry in the list of add-ons."""
        layout = self.layout
        _draw_packages(layout.box(), find_packages(), self.checked)
        column = layout.column()
        column.use_property_split, column.use_property_decorate = True, False
        column.prop(self, "threads", text="Threads" if self.threads else "Threads (Automatic)")
        column.separator()
        column.prop(self, "cache", placeholder=cache_folder() or "")
        row = layout.row()
        row.label(text=f"The cache holds {_megabytes(_cache_size(cache_folder(), int(time.monotonic() / SIZE_SECONDS)))}")
        row.operator("preferences.npmesh_clear_cache", icon="TRASH")


def _draw_packages(layout: bpy.types.UILayout, status: tuple[packages.Status, ...], checked: str) -> None:
    """One line for each package, and below one that is missing, the remedy."""
    for entry in status:
        package = entry.package
        row = layout.row()
        row.alert = bool(entry.problem) and package.needed
        icon = "CHECKMARK" if not entry.problem else "ERROR" if package.needed else "INFO"
        title = row.split(factor=0.3)
        title.label(text=f"{package.name} {entry.version}", icon=icon)
        title.label(text=package.purpose)
        if entry.problem:
            below = layout.column(align=True)
            below.alert = row.alert
            for text in (entry.problem, package.remedy):
                below.label(text=text[0].upper() + text[1:], icon="BLANK1")
    if checked:
        layout.separator()
        lines = layout.column(align=True)
        for line in ("As compressing finds them:", *checked.splitlines()):
            lines.label(text=line, icon="BLANK1")
    layout.operator("preferences.npmesh_check", icon="FILE_REFRESH")


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.1f} MB"


@lru_cache(maxsize=1)
def find_packages() -> tuple[packages.Status, ...]:
    """`packages.found`, remembered while the preferences are drawn again and again."""
    return packages.found()


def forget_status() -> None:
    """Look for packages again, and count the cache again, when they are next drawn."""
    find_packages.cache_clear()
    _cache_size.cache_clear()


@lru_cache(maxsize=4)
def _cache_size(folder: str | None, moment: int) -> int:
    """Bytes in the cache; `moment` changes when it is to be counted again."""
    return caches.size(Path(folder)) if folder else 0


def current() -> NpmPreferences | None:
    """The preferences; None where the package is registered without being an enabled add-on."""
    addon = bpy.context.preferences.addons.get(__package__)
    return addon.preferences if addon else None


def cache_folder() -> str | None:
    """The folder for compiled code and results; it is made if it is missing.

    None for the plain package, which keeps them beside its sources and in the user's cache. A folder that was chosen
    and cannot be made or written to counts as not chosen.
    """
    preferences = current()
    if preferences is not None and preferences.cache:
        folder = Path(bpy.path.abspath(preferences.cache)).absolute() / "npm_blender"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            return str(folder)
        except OSError:
            pass
    if not __package__.startswith("bl_ext."):
        return None
    return bpy.utils.extension_path_user(__package__, path="cache", create=True)


def worker_settings() -> WorkerSettings:
    """What a worker process that starts now may use."""
    preferences = current()
    return WorkerSettings(preferences.threads if preferences else 0, cache_folder())


CLASSES = (NpmPreferences,)
