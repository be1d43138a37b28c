"""The tab Progressive in the sidebar of the 3D viewport."""
import textwrap

import bpy

from .. import jobs, preview
from ..operators.compress import OBJECT_OT_npmesh_cancel, OBJECT_OT_npmesh_compress
from ..operators.decoded import OBJECT_OT_npmesh_apply, OBJECT_OT_npmesh_discard, OBJECT_OT_npmesh_preview
from ..operators.export_stream import EXPORT_SCENE_OT_npmesh
from ..properties import draw_settings


class _Sidebar:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Progressive"


class VIEW3D_PT_npmesh_preview(_Sidebar, bpy.types.Panel):
    """Detail and level of a preview, what it costs, and what to do with it."""

    bl_label = "Progressive Preview"

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and context.active_object.npmesh.is_preview

    def draw(self, context):
        obj = context.active_object
        state, layout = obj.npmesh, self.layout
        if state.problem:
            _lines(layout, state.problem, "ERROR", context.region.width, alert=True)
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
            _lines(layout, f"Cut off: {state.arrived_features:,} of {state.total_features:,} features arrived", "INFO",
                   context.region.width)
        row = layout.row()
        row.active = state.source is not None
        row.prop(state, "show_original", toggle=True, icon="MOD_MIRROR")
        layout.operator(EXPORT_SCENE_OT_npmesh.bl_idname, text="Export .npmesh", icon="EXPORT")
        row = layout.row(align=True)
        row.operator(OBJECT_OT_npmesh_apply.bl_idname, text="Apply", icon="CHECKMARK")
        row.operator(OBJECT_OT_npmesh_discard.bl_idname, text="Discard", icon="X")


class VIEW3D_PT_npmesh_compress(_Sidebar, bpy.types.Panel):
    """Settings, Compress, and the progress of a running job."""

    bl_label = "Progressive Compression"

    def draw(self, context):
        layout, obj = self.layout, context.active_object
        source = obj.npmesh.source if obj is not None and obj.npmesh.is_preview else obj
        for job in jobs.running():
            row = layout.row(align=True)
            row.progress(factor=job.fraction, text=f"{job.message}  {100 * job.fraction:.0f}%")
            row.operator(OBJECT_OT_npmesh_cancel.bl_idname, text="", icon="X")
        if source is None or source.type != "MESH":
            layout.label(text="Opened from a file" if obj and obj.npmesh.is_preview else "Select a mesh object")
            return
        settings = layout.column()
        settings.use_property_split, settings.use_property_decorate = True, False
        draw_settings(settings, source.npmesh)
        if not jobs.running():
            again = isinstance(source.get(preview.STREAM), bytes)
            button = layout.row()
            button.scale_y = 1.4
            button.operator(OBJECT_OT_npmesh_compress.bl_idname, text="Compress Again" if again else "Compress")
            if again and not obj.npmesh.is_preview:
                layout.operator(OBJECT_OT_npmesh_preview.bl_idname, text="Show Preview", icon="HIDE_OFF")
        if source.npmesh.report:
            for line in source.npmesh.report.splitlines():
                _lines(layout, line, "INFO", context.region.width)


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


def _lines(layout: bpy.types.UILayout, text: str, icon: str, width: int, alert: bool = False) -> None:
    """Text broken into as many labels as the panel's width in pixels needs."""
    column = layout.column(align=True)
    column.alert = alert
    letters = max(int(width / (7.2 * bpy.context.preferences.system.ui_scale)) - 6, 16)
    for k, line in enumerate(textwrap.wrap(text, letters)):
        column.label(text=line, icon="BLANK1" if k else icon)


def size_text(size: int) -> str:
    """A number of bytes with the unit that a file manager would show (1 kB = 1000 bytes)."""
    for unit, scale in (("MB", 1e6), ("kB", 1e3)):
        if size >= scale:
            return f"{size / scale:.1f} {unit}"
    return f"{size} bytes"


def percent_text(size: int, whole: int) -> str:
    """A share with two digits that count."""
    share = 100 * size / max(whole, 1)
    return f"{share:.0f}%" if share >= 10 else f"{share:.1f}%" if share >= 1 else f"{share:.2f}%"


CLASSES = (VIEW3D_PT_npmesh_preview, VIEW3D_PT_npmesh_compress)
