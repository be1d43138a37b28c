"""What to do with a compressed object and its preview: show it, go to a stop, keep it as an ordinary mesh, drop it."""
import bpy
from bpy.props import IntProperty

from .. import preview
from ..core.errors import NpmError, StreamError
from .compress import preview_of
from .job_operator import one_line
from .preview_operator import PreviewOperator
from .target import poll_mesh


class OBJECT_OT_npmesh_preview(bpy.types.Operator):
    """Show the compressed mesh in place of the active object, which was compressed before"""

    bl_idname = "object.npmesh_preview"
    bl_label = "Preview Compressed Mesh"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    @classmethod
    def poll(cls, context):
        return poll_mesh(cls, context)

    def execute(self, context):
        obj = context.active_object
        try:
            if obj.npmesh.is_preview:
                preview.show(obj)
                return {"FINISHED"}
            if not preview.has_stream(obj):
                raise StreamError(f"Expected a compressed object, found none in '{obj.name}'; compress it first")
            shown = preview_of(context, obj)
        except NpmError as error:
            self.report({"ERROR"}, one_line(error))
            return {"CANCELLED"}
        shown.npmesh.show_original = False
        context.view_layer.objects.active = shown
        return {"FINISHED"}


class OBJECT_OT_npmesh_stop(PreviewOperator, bpy.types.Operator):
    """Use this many features, for which the error was measured"""

    bl_idname = "object.npmesh_stop"
    bl_label = "Go to Stop"
    bl_options = {"UNDO", "INTERNAL"}  # noqa: RUF012

    features: IntProperty(name="Features", min=0, description="How many features to use")

    def execute(self, context):
        context.active_object.npmesh.features = self.features
        return {"FINISHED"}


class OBJECT_OT_npmesh_apply(PreviewOperator, bpy.types.Operator):
    """Keep what the preview shows as an ordinary mesh object; the original stays hidden"""

    bl_idname = "object.npmesh_apply"
    bl_label = "Apply Preview"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    def execute(self, context):
        preview.apply(context.active_object)
        return {"FINISHED"}


class OBJECT_OT_npmesh_discard(PreviewOperator, bpy.types.Operator):
    """Remove the preview and bring the original back"""

    bl_idname = "object.npmesh_discard"
    bl_label = "Discard Preview"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    def execute(self, context):
        preview.discard(context.active_object, context.view_layer)
        return {"FINISHED"}


CLASSES = (OBJECT_OT_npmesh_preview, OBJECT_OT_npmesh_stop, OBJECT_OT_npmesh_apply, OBJECT_OT_npmesh_discard)
