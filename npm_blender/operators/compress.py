"""Compress: the active mesh object, modifiers applied, into a stream that is kept on the object, and preview it."""
import bpy
from bpy.props import BoolProperty

from .. import bridge, jobs, preview
from ..core.errors import NpmError
from ..properties import CompressionProperties
from .job_operator import ObjectJobOperator, one_line
from .target import chosen_settings, fingerprint, poll_mesh, source_of


def store(obj: bpy.types.Object, result: jobs.Compressed, made_from: str) -> None:
    """Keep a compressed stream and its report on `obj`."""
    preview.pack(obj, result.stream)
    obj.npmesh.fingerprint = made_from
    lines = [result.report["cleaning"], *result.report["messages"]]
    obj.npmesh.report = "\n".join(line[0].upper() + line[1:] for line in lines if line)


class OBJECT_OT_npmesh_compress(CompressionProperties, ObjectJobOperator, bpy.types.Operator):
    """Compress the active mesh object, with its modifiers applied, and show the result in its place"""

    bl_idname = "object.npmesh_compress"
    bl_label = "Compress Progressively"
    bl_options = {"UNDO"}  # noqa: RUF012 - Blender's own form

    make_preview: BoolProperty(
        name="Preview", default=True, options={"SKIP_SAVE"},
        description="Hide the original and show the compressed mesh in its place")

    @classmethod
    def poll(cls, context):
        if jobs.running():
            cls.poll_message_set("Expected no running job, found one; wait for it or cancel it")
            return False
        return poll_mesh(cls, context)

    def execute(self, context):
        try:
            source = source_of(context.active_object, context.view_layer)
            settings = chosen_settings(self, source)
            mesh = bridge.mesh_of(source, context.evaluated_depsgraph_get())
            self._fingerprint = fingerprint(mesh, settings)
            return self.compress(context, source, mesh, settings)
        except (NpmError, OSError) as error:
            self.report({"ERROR"}, one_line(error))
            return {"CANCELLED"}

    def store_and_show(self, context, obj, result):
        store(obj, result, self._fingerprint)
        done = f"Compressed '{obj.name}': {result.report['faces']:,} faces to {len(result.stream.data):,} bytes"
        if self.make_preview and context.mode != "OBJECT":  # the user went on working: nothing moves under the mouse
            self.report({"INFO"}, f"{done}; to see it, leave this mode and press Show Preview")
            return
        if self.make_preview:
            preview_of(context, obj)
        self.report({"INFO"}, done)


def preview_of(context: bpy.types.Context, obj: bpy.types.Object) -> bpy.types.Object:
    """Show the stream that is kept on `obj`: in its preview if it has one, else in a new one.

    Raises StreamError, WeightsError or DependencyError.
    """
    shown = preview.find(obj, context.view_layer)
    received = preview.packed(obj)
    if shown is None:
        return preview.make(context, received, f"{obj.name} Preview", obj)
    preview.set_stream(shown, received)
    shown.npmesh.report = obj.npmesh.report
    return shown


class OBJECT_OT_npmesh_cancel(bpy.types.Operator):
    """Stop compressing; nothing is changed"""

    bl_idname = "object.npmesh_cancel"
    bl_label = "Cancel Compressing"
    bl_options = {"INTERNAL"}  # noqa: RUF012

    @classmethod
    def poll(cls, context):
        return bool(jobs.running())

    def execute(self, context):
        jobs.cancel_all()
        return {"FINISHED"}


def menu(self, context):
    """Entry of the Object menu."""
    self.layout.separator()
    self.layout.operator(OBJECT_OT_npmesh_compress.bl_idname, icon="MOD_DECIM")


CLASSES = (OBJECT_OT_npmesh_compress, OBJECT_OT_npmesh_cancel)
