"""The panel of a preview: what is shown, what it costs, and what to do with it."""
import bpy

from ..operators.decoded import OBJECT_OT_npmesh_apply, OBJECT_OT_npmesh_discard
from ..operators.export_stream import EXPORT_SCENE_OT_npmesh
from .common import Sidebar, lines, percent_text, size_text


class VIEW3D_PT_npmesh_preview(Sidebar, bpy.types.Panel):
    """Detail and level of a preview, what it costs, and what to do with it."""

    bl_label = "Progressive Preview"

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and context.active_object.npmesh.is_preview

    def draw(self, context):
        obj = context.active_object
        state, layout = obj.npmesh, self.layout
        if state.problem:
            lines(layout, state.problem, "ERROR", context.region.width, alert=True)
            return
        body = layout.column()
        body.enabled = obj.mode == "OBJECT"
        levels = body.row(align=True)
        levels.label(text="Level")
        for level in range(state.level_count + 1):
            levels.prop_enum(state, "level", str(level))
        column = body.column(align=True)
        column.prop(state, "detail", slider=True)
        row = column.row(align=True)
        row.prop(state, "features")
        total = row.row(align=True)
        total.alignment = "RIGHT"
        total.label(text=f"of {state.total_features:,}")
        _facts(layout, state)
        if state.arrived_features < state.total_features:
            lines(layout, f"Cut off: {state.arrived_features:,} of {state.total_features:,} features arrived", "INFO",
                   context.region.width)
        row = layout.row()
        row.active = state.source is not None
        row.prop(state, "show_original", toggle=True, icon="MOD_MIRROR")
        layout.operator(EXPORT_SCENE_OT_npmesh.bl_idname, text="Export .npmesh", icon="EXPORT")
        row = layout.row(align=True)
        row.operator(OBJECT_OT_npmesh_apply.bl_idname, text="Apply", icon="CHECKMARK")
        row.operator(OBJECT_OT_npmesh_discard.bl_idname, text="Discard", icon="X")


def _facts(layout: bpy.types.UILayout, state) -> None:
    """The live lines: faces, bytes, and the share of the original."""
    box = layout.box().column(align=True)
    share = percent_text(state.shown_bytes, state.source_bytes)
    for name, value in (
            ("Faces", f"{state.shown_faces:,} of {state.source_faces:,}"),
            ("Size", f"{size_text(state.shown_bytes)} of {size_text(state.stream_bytes)}"),
            ("Of Original", f"{share} of {size_text(state.source_bytes)} PLY")):
        split = box.split(factor=0.36)
        split.label(text=name)
        split.label(text=value)


CLASSES = (VIEW3D_PT_npmesh_preview,)
