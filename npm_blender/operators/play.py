"""Play the stream of a preview as it would arrive over a line: what arrives first, and how soon."""
import bpy

from ..core.errors import NpmError
from ..preview import playback
from ..preview.viewport import redraw_panels
from .job_operator import one_line
from .target import poll_preview

TIMER_SECONDS = 0.05


class OBJECT_OT_npmesh_play(bpy.types.Operator):
    """Play the stream from its first byte, as over the line above, up to the features that are set now. \
Esc stops"""

    bl_idname = "object.npmesh_play"
    bl_label = "Play"
    bl_options = {"INTERNAL"}  # noqa: RUF012 - it ends as it began: there is nothing to undo

    @classmethod
    def poll(cls, context):
        if bpy.app.background:
            cls.poll_message_set("Expected a window to play in, found none; start Blender without -b")
            return False
        return poll_preview(cls, context)

    def execute(self, context):
        obj = context.active_object
        try:
            playback.stop(obj)
            self._play = playback.start(obj)
            self._play.step(obj)
        except NpmError as error:
            self.report({"ERROR"}, one_line(error))
            return {"CANCELLED"}
        self._timer = context.window_manager.event_timer_add(TIMER_SECONDS, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        obj = next((o for o in bpy.data.objects if o.session_uid == self._play.uid), None)
        ended = obj is None or playback.of(obj) is not self._play
        if not ended and event.type == "ESC" and event.value == "PRESS":
            playback.stop(obj)
            self._clean_up(context)
            return {"CANCELLED"}
        if not ended and event.type == "TIMER":
            try:
                going = obj.mode == "OBJECT" and self._play.step(obj)
            except NpmError as error:
                self.report({"ERROR"}, one_line(error))
                going = False
            if not going:
                playback.stop(obj)
                ended = True
            self._redraw(context)
        if ended:
            playback.drop(self._play)
            self._clean_up(context)
            return {"FINISHED"}
        return {"PASS_THROUGH"}

    def cancel(self, context):
        """Called by Blender when it ends the operator: another file is loaded, the window closes."""
        playback.stop_all()
        self._clean_up(context)

    def _clean_up(self, context):
        context.window_manager.event_timer_remove(self._timer)
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        self._redraw(context)

    def _redraw(self, context):
        play = self._play
        if playback.is_running(play) and context.workspace is not None:
            what = "base mesh arriving" if play.arrived < play.base else f"{play.elapsed:.1f} s"
            context.workspace.status_text_set(f"Playing: {play.arrived:,} of {play.end:,} bytes, {what}      Esc: Stop")
        redraw_panels()


class OBJECT_OT_npmesh_stop_playing(bpy.types.Operator):
    """Stop playing, and use the features again that were set before"""

    bl_idname = "object.npmesh_stop_playing"
    bl_label = "Stop Playing"
    bl_options = {"INTERNAL"}  # noqa: RUF012

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and playback.is_playing(context.active_object)

    def execute(self, context):
        playback.stop(context.active_object)
        return {"FINISHED"}


CLASSES = (OBJECT_OT_npmesh_play, OBJECT_OT_npmesh_stop_playing)
