"""What Compress, Export and Import share: run one job, in the window without stopping it, elsewhere to the end."""
from collections.abc import Generator

import bpy

from .. import jobs, preview
from ..core.errors import NpmError
from ..jobs import estimate
from ..preview.viewport import redraw_panels

TIMER_SECONDS = 0.1
_WARM = object()  # what `_warming` yields once it has ended
Steps = Generator[None, None, set | None]


class JobOperator:
    """Mix-in of an operator: `run_job` takes a job that has started, `finish` gets its result.

    In a window, an operator that was invoked runs modal: progress in the status bar and the panel, Esc cancels. From a
    script or in the background it blocks until the job has ended.
    """

    _job: jobs.Job | None = None
    _steps: Steps | None = None
    _text: str | None = None

    def doing(self) -> str:
        """What the job does now, for the status bar and the panel, as "Compressing 'Cube'"."""
        raise NotImplementedError

    def feed(self, context: bpy.types.Context) -> bool:
        """Give the running job a piece of its work; False once it has everything."""
        return False

    def finish(self, context: bpy.types.Context, result) -> Steps:
        """What to do with the job's result, as a generator that yields where the window may draw.

        Its return value is the operator's result, None for FINISHED. May raise NpmError or OSError.
        """
        raise NotImplementedError

    def blocks(self) -> bool:
        """Whether whoever called the operator waits for its result."""
        return bpy.app.background or not self.options.is_invoke

    def run_job(self, context: bpy.types.Context, job: jobs.Job) -> set:
        """Let `job` end; returns the operator's result."""
        self._job, self._warming = job, preview.warm_up()
        if self.blocks():
            try:
                while self.feed(context):
                    pass
            except BaseException:
                job.cancel()
                raise
            return self.run_steps(context, self._blocking(context))
        manager = context.window_manager
        self._timer = manager.event_timer_add(TIMER_SECONDS, window=context.window)
        manager.modal_handler_add(self)
        self._show(context)
        return {"RUNNING_MODAL"}

    def _blocking(self, context: bpy.types.Context) -> Steps:
        return (yield from self.finish(context, self._job.wait()))

    def run_steps(self, context: bpy.types.Context, steps: Steps) -> set:
        """All steps at once; returns the operator's result."""
        self._steps = steps
        while (result := self._step(context)) is None:
            pass
        return result

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set:
        """Called by Blender for every event while the job runs."""
        try:
            result = self._advance(context, event)
        except BaseException:
            self.cancel(context)
            raise
        if result is None:
            return {"PASS_THROUGH"}
        self._clean_up(context)
        return result

    def _advance(self, context: bpy.types.Context, event: bpy.types.Event) -> set | None:
        """What an event brings; the operator's result at the end."""
        job = self._job
        if self._steps is None:
            if event.type == "ESC" and event.value == "PRESS":
                job.cancel()
            if job not in jobs.running():  # by Esc, by the panel's button, or because the extension is being disabled
                self.report({"INFO"}, f"{self.doing()} was cancelled")
                return {"CANCELLED"}
        if event.type != "TIMER":
            return None
        if self._steps is not None:
            return self._step(context)
        try:
            if not self.feed(context) and next(self._warming, _WARM) is _WARM and job.poll():
                self._steps = self.finish(context, job.result())
        except (NpmError, OSError) as error:
            job.cancel()
            self.report({"ERROR"}, one_line(error))
            return {"CANCELLED"}
        self._show(context)
        return None

    def cancel(self, context: bpy.types.Context) -> None:
        """Called by Blender when it ends the operator: another file is loaded, the file browser or window closes."""
        if self._job is not None:
            self._job.cancel()
            self._clean_up(context)

    def _step(self, context: bpy.types.Context) -> set | None:
        """One step of the finish; the operator's result once it was the last."""
        try:
            next(self._steps)
            return None
        except StopIteration as end:
            return end.value or {"FINISHED"}
        except (NpmError, OSError) as error:
            self.report({"ERROR"}, one_line(error))
            return {"CANCELLED"}

    def _show(self, context: bpy.types.Context) -> None:
        job = self._job
        job.doing = self.doing()
        text = f"{job.doing}: {job.message} ({100 * job.fraction:.0f}%)"
        left = job.seconds_left()
        if left is not None:
            text += f", about {estimate.text(left)} left"
        if text != self._text:
            self._say(context, text + "      Esc: Cancel")
            self._text = text

    def _clean_up(self, context: bpy.types.Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        self._say(context, None)

    def _say(self, context: bpy.types.Context, text: str | None) -> None:
        """Set the status bar and draw the sidebars again."""
        if context.workspace is not None:
            context.workspace.status_text_set(text)
        redraw_panels()


def one_line(error: Exception) -> str:
    """An error as one line for a report."""
    if isinstance(error, OSError):
        return f"{error.strerror or error}{f': {error.filename}' if error.filename else ''}"
    return " ".join(str(error).split())
