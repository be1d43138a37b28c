"""Buttons of the preferences: check the packages where they are used, and clear the cache."""
from pathlib import Path

import bpy

from .. import jobs, preferences
from ..core.errors import NpmError
from ..runtime import caches
from .job_operator import JobOperator, one_line


class PREFERENCES_OT_npmesh_check(JobOperator, bpy.types.Operator):
    """Load every package as compressing does, in another process, and show versions and places"""

    bl_idname = "preferences.npmesh_check"
    bl_label = "Check Packages"
    bl_options = {"INTERNAL"}  # noqa: RUF012 - Blender's own form

    @classmethod
    def poll(cls, context):
        return _no_job(cls)

    def doing(self):
        return "Checking packages"

    def execute(self, context):
        preferences.forget_status()
        try:
            return self.run_job(context, jobs.CheckJob(bpy.app.tempdir, preferences.worker_settings()))
        except (NpmError, OSError) as error:
            self.report({"ERROR"}, one_line(error))
            return {"CANCELLED"}

    def finish(self, context, result):
        lines = [_line(entry) for entry in result]
        chosen = preferences.current()
        if chosen is not None:
            chosen.checked = "\n".join(lines)
        for line in lines:
            self.report({"INFO"}, line)
        return {"FINISHED"}
        yield  # a generator, as JobOperator asks


def _line(entry: dict) -> str:
    if "problem" in entry:
        return f"{entry['name']}: {entry['problem']}"
    return f"{entry['name']} {entry['version']}, from {Path(entry['path']).parents[1]}"


class PREFERENCES_OT_npmesh_clear_cache(bpy.types.Operator):
    """Remove compiled code and remeshed surfaces; the next compressing makes them again, which takes a minute"""

    bl_idname = "preferences.npmesh_clear_cache"
    bl_label = "Clear Cache"
    bl_options = {"INTERNAL"}  # noqa: RUF012

    @classmethod
    def poll(cls, context):
        if preferences.cache_folder() is None:
            cls.poll_message_set("Expected an installed extension, found its source, which keeps no cache of its own")
            return False
        return _no_job(cls)

    def execute(self, context):
        removed, refused = caches.clear(Path(preferences.cache_folder()))
        preferences.forget_status()
        if refused:
            self.report({"WARNING"}, f"Removed {removed / 1e6:.1f} MB; {refused} files are in use or not yours to "
                                     "remove, close other Blenders and try again")
        else:
            self.report({"INFO"}, f"Removed {removed / 1e6:.1f} MB")
        return {"FINISHED"}


def _no_job(cls) -> bool:
    if jobs.running():
        cls.poll_message_set("Expected no running job, found one; wait for it or cancel it")
        return False
    return True


CLASSES = (PREFERENCES_OT_npmesh_check, PREFERENCES_OT_npmesh_clear_cache)
