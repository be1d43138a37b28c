"""What Compress, Export and Import share: run one job, in the window without stopping it, elsewhere to the end."""
from collections.abc import Callable
from typing import TYPE_CHECKING

import bpy

from .. import jobs
from ..core.errors import NpmError
from ..core.settings import CompressSettings
from ..dependencies import cache_folder

if TYPE_CHECKING:
    from ..core.mesh import TriMesh

TIMER_SECONDS = 0.1


class JobOperator:
    """Mix-in of an operator: `run_job` takes a job that has started, `finish` gets its result.

    In a window, an operator that was invoked runs modal: progress in the status bar and the panel, Esc cancels. From a
    script or in the background it blocks until the job has ended.
    """

    _job: jobs.Job | None = None
    _text: str | None = None

    def finish(self, context: bpy.types.Context, result) -> set | None:
        """What to do with the job's result. Returns the operator's result, None for FINISHED.

        May raise NpmError or OSError.
        """
        raise NotImplementedError

    def blocks(self) -> bool:
        """Whether whoever called the operator waits for its result."""
        return bpy.app.background or not self.options.is_invoke

    def run_job(self, context: bpy.types.Context, job: jobs.Job, doing: str) -> set:
        """Let `job` end; returns the operator's result. doing: for the status bar, as "Compressing 'Cube'"."""
        if self.blocks():
            return self._deliver(context, job.wait)
        self._job, self._doing = job, doing
        manager = context.window_manager
        self._timer = manager.event_timer_add(TIMER_SECONDS, window=context.window)
        manager.modal_handler_add(self)
        self._show(context)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set:
        """Called by Blender for every event while the job runs."""
        job = self._job
        if event.type == "ESC" and event.value == "PRESS":
            job.cancel()
        if job not in jobs.running():  # by Esc, by the panel's button, or because the extension is being disabled
            self._clean_up(context)
            self.report({"INFO"}, f"{self._doing} was cancelled")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if not job.poll():
            self._show(context)
            return {"PASS_THROUGH"}
        self._clean_up(context)
        return self._deliver(context, job.result)

    def cancel(self, context: bpy.types.Context) -> None:
        """Called by Blender when it ends the operator: another file is loaded, the file browser or window closes."""
        if self._job is not None:
            self._job.cancel()
            self._clean_up(context)

    def _deliver(self, context: bpy.types.Context, result_of: Callable[[], object]) -> set:
        try:
            return self.finish(context, result_of()) or {"FINISHED"}
        except (NpmError, OSError) as error:
            self.report({"ERROR"}, one_line(error))
            return {"CANCELLED"}

    def _show(self, context: bpy.types.Context) -> None:
        text = f"{self._doing}: {self._job.message} ({100 * self._job.fraction:.0f}%)      Esc: Cancel"
        if text != self._text:
            self._say(context, text)

    def _clean_up(self, context: bpy.types.Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        self._say(context, None)

    def _say(self, context: bpy.types.Context, text: str | None) -> None:
        """Set the status bar and draw the sidebars again; not the viewports, which may take long."""
        self._text = text
        if context.workspace is not None:
            context.workspace.status_text_set(text)
        for window in context.window_manager.windows:
            for area in window.screen.areas:
                for region in area.regions:
                    if area.type == "VIEW_3D" and region.type == "UI":
                        region.tag_redraw()


class ObjectJobOperator(JobOperator):
    """A JobOperator that compresses one object; `store_and_show` gets the object and the result."""

    def store_and_show(self, context: bpy.types.Context, obj: bpy.types.Object, result: jobs.Compressed) -> None:
        """What to do with the result for `obj`. May raise NpmError or OSError."""
        raise NotImplementedError

    def compress(self, context: bpy.types.Context, obj: bpy.types.Object, mesh: "TriMesh",
                 settings: CompressSettings) -> set:
        """Compress `mesh` for `obj`; returns the operator's result. Raises DependencyError or OSError."""
        self._uid, self._name = obj.session_uid, obj.name
        job = jobs.CompressJob(mesh, settings, scratch=bpy.app.tempdir, cache=cache_folder())
        return self.run_job(context, job, f"Compressing '{obj.name}'")

    def finish(self, context: bpy.types.Context, result: jobs.Compressed) -> set | None:
        """Find the object again: while the job ran, anything may have happened."""
        obj = next((o for o in bpy.data.objects if o.session_uid == self._uid), None)
        if obj is None or obj.name not in context.view_layer.objects:
            self.report({"WARNING"}, f"'{self._name}' was removed while it was compressed; the result is dropped")
            return {"CANCELLED"}
        return self.store_and_show(context, obj, result)


def one_line(error: Exception) -> str:
    """An error as one line for a report."""
    if isinstance(error, OSError):
        return f"{error.strerror or error}{f': {error.filename}' if error.filename else ''}"
    return " ".join(str(error).split())
