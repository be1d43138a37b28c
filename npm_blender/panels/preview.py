"""The panel of a preview: what is shown, what it costs and how far it is off; parts that fold away below it."""
import bpy

from .. import preview
from ..core.errors import StreamError
from ..operators import decoded, lod_set, play, storage
from ..operators.export_gltf import EXPORT_SCENE_OT_npmesh_gltf
from ..operators.export_stream import EXPORT_SCENE_OT_npmesh
from ..preview import deviation, playback
from ..preview.storage import measured_text, quality
from .common import Sidebar, icon_of, length_text, lines, percent_text, short_count, size_text

LEVELS_IN_ROW = 4


class VIEW3D_PT_npmesh_preview(Sidebar, bpy.types.Panel):
    """Detail and level of a preview, what it costs, and what to do with it."""

    bl_label = "Progressive Preview"

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and context.active_object.npmesh.is_preview

    def draw(self, context):
        obj = context.active_object
        state, layout, width = obj.npmesh, self.layout, context.region.width
        reason = preview.foreign(obj)
        if reason or state.problem:
            lines(layout, reason or state.problem, "ERROR", width, alert=True)
            if not reason:
                _remedies(layout, obj)
                _end(layout)
            return
        body = layout.column()
        body.enabled = obj.mode == "OBJECT" and not playback.is_playing(obj)
        body.label(text="Level, with its faces")
        levels = body.grid_flow(row_major=True, columns=min(state.level_count + 1, LEVELS_IN_ROW), even_columns=True,
                                align=True)
        for level in range(state.level_count + 1):
            levels.prop_enum(state, "level", str(level),
                             text=f"{level}: {short_count(state.meshes[level].faces)}")
        column = body.column(align=True)
        column.prop(state, "detail", slider=True)
        row = column.row(align=True)
        row.prop(state, "features")
        total = row.row(align=True)
        total.alignment = "RIGHT"
        total.label(text=f"of {state.total_features:,}")
        column.prop(state, "budget")
        _facts(layout, obj, context.scene)
        if state.shortfall:
            lines(layout, f"The stream {state.shortfall}", "INFO", width)
        row = layout.row(align=True)
        row.active = state.source is not None
        row.prop(state, "show_original", toggle=True, icon="MOD_MIRROR")
        row.prop(state, "beside", toggle=True, icon="ARROW_LEFTRIGHT")
        _end(layout)


class _Part(Sidebar):
    """A part of the preview's panel that folds away."""

    bl_parent_id = "VIEW3D_PT_npmesh_preview"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012 - Blender's own form

    @classmethod
    def poll(cls, context):
        obj = context.active_object
        return obj is not None and not obj.npmesh.problem and not preview.foreign(obj)


class VIEW3D_PT_npmesh_stops(_Part, bpy.types.Panel):
    """Bytes and measured error at stops along the features; a click goes there."""

    bl_label = "Stops"

    def draw(self, context):
        obj, layout = context.active_object, self.layout
        quality = _quality(obj)
        if quality is None:
            lines(layout, "Not measured: the original was not at hand when this was opened", "INFO",
                  context.region.width)
            return
        level = min(int(obj.npmesh.level), len(quality.errors) - 1)
        column = layout.column(align=True)
        _columns(column, ("Features", "Size", "Error"))
        for features, size, errors in zip(quality.features, quality.bytes, quality.errors[level], strict=True):
            row = _columns(column, (None, size_text(size), _distance(errors.worse, quality, context.scene)))
            go = row.operator(decoded.OBJECT_OT_npmesh_stop.bl_idname, text=f"{features:,}",
                              depress=features == obj.npmesh.features)
            go.features = features
        lines(layout, f"Error: mean distance between level {level} and the original, the worse way, measured when it was "
                      "compressed", "BLANK1", context.region.width)


class VIEW3D_PT_npmesh_deviation(_Part, bpy.types.Panel):
    """The deviation as colours, and what they mean."""

    bl_label = "Deviation"
    bl_options = set()  # noqa: RUF012 - open, as the colours are nothing without their legend

    def draw_header(self, context):
        self.layout.prop(context.active_object.npmesh, "show_deviation", text="")

    def draw(self, context):
        layout, state, width = self.layout, context.active_object.npmesh, context.region.width
        if state.deviation_problem:
            lines(layout, state.deviation_problem, "ERROR", width, alert=True)
            return
        layout.active = state.show_deviation
        layout.prop(state, "deviation_top")
        if not state.show_deviation or state.deviation_top <= 0:
            lines(layout, "Colours by the distance to the original" if not state.show_deviation else "Measuring", "INFO",
                  width)
            return
        column = layout.column(align=True)
        column.scale_y = 0.8
        entries = deviation.legend(state)
        for k, (distance, colour) in enumerate(entries):
            text = length_text(distance, context.scene)
            column.label(text=f"{text} and more" if k == 0 else text, icon_value=icon_of(colour))
        mean, largest = (length_text(d, context.scene) for d in (state.deviation_mean, state.deviation_max))
        lines(layout, f"Mean {mean}, at most {largest}, at the vertices", "BLANK1", width)


class VIEW3D_PT_npmesh_play(_Part, bpy.types.Panel):
    """What arrives first, played."""

    bl_label = "What Arrives First"

    def draw(self, context):
        layout, obj = self.layout, context.active_object
        running = playback.of(obj)
        if running is None:
            layout.prop(obj.npmesh, "play_rate")
            layout.operator(play.OBJECT_OT_npmesh_play.bl_idname, icon="PLAY")
            return
        row = layout.row(align=True)
        row.progress(factor=running.fraction,
                     text=f"{size_text(running.arrived)} of {size_text(running.end)} in {running.elapsed:.1f} s")
        row.operator(play.OBJECT_OT_npmesh_stop_playing.bl_idname, text="", icon="X")


class VIEW3D_PT_npmesh_output(_Part, bpy.types.Panel):
    """Ways out: to other tools, to a file, into the .blend."""

    bl_label = "Output"

    def draw(self, context):
        layout, obj = self.layout, context.active_object
        column = layout.column(align=True)
        column.operator(lod_set.OBJECT_OT_npmesh_lod_set.bl_idname, icon="MOD_INSTANCE")
        column.operator(EXPORT_SCENE_OT_npmesh_gltf.bl_idname, text="Export Level as glTF", icon="EXPORT")
        column.operator(EXPORT_SCENE_OT_npmesh.bl_idname, text="Export .npmesh", icon="EXPORT")
        column = layout.column(align=True)
        if preview.is_linked(obj):
            lines(column, f"Linked from {obj.npmesh.filepath}", "LINKED", context.region.width)
            column.operator(storage.OBJECT_OT_npmesh_pack.bl_idname, icon="PACKAGE")
        else:
            lines(column, f"Packed: {size_text(obj.npmesh.stream_bytes)} in this .blend", "PACKAGE",
                  context.region.width)
            column.operator(storage.OBJECT_OT_npmesh_link.bl_idname, icon="LINKED")


def _remedies(layout: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """What to do about a linked file that is missing or was changed."""
    if preview.is_linked(obj):
        row = layout.row(align=True)
        row.prop(obj.npmesh, "filepath", text="")
        row.operator(storage.OBJECT_OT_npmesh_reload.bl_idname, text="", icon="FILE_REFRESH")


def _end(layout: bpy.types.UILayout) -> None:
    row = layout.row(align=True)
    row.operator(decoded.OBJECT_OT_npmesh_apply.bl_idname, text="Apply", icon="CHECKMARK")
    row.operator(decoded.OBJECT_OT_npmesh_discard.bl_idname, text="Discard", icon="X")


def _facts(layout: bpy.types.UILayout, obj: bpy.types.Object, scene: bpy.types.Scene) -> None:
    """The live lines: faces, bytes, the share of the original, and the error."""
    state = obj.npmesh
    box = layout.box().column(align=True)
    share = percent_text(state.shown_bytes, state.source_bytes)
    for name, value in (
            ("Faces", f"{state.shown_faces:,} of {state.source_faces:,}"),
            ("Size", f"{size_text(state.shown_bytes)} of {size_text(state.stream_bytes)}"),
            ("Of Original", f"{share} of {size_text(state.source_bytes)} PLY"),
            *_errors(obj, scene)):
        split = box.split(factor=0.36)
        split.label(text=name)
        split.label(text=value)


def _errors(obj: bpy.types.Object, scene: bpy.types.Scene) -> tuple[tuple[str, str], ...]:
    """The measured error of what is shown, the worse way: at a stop as it is, else that of the stops on both sides."""
    state, quality = obj.npmesh, _quality(obj)
    if quality is None or int(state.level) >= len(quality.errors):
        return (("Error", "not known, no original"),)
    values = sorted(errors.worse for errors in quality.around(state.features, int(state.level)))
    lengths = [length_text(value * 1e-4 * quality.size, scene) for value in values]
    shares = [f"{value * 1e-2:.2g}" for value in values]
    return (("Error", " to ".join(dict.fromkeys(lengths))), ("Of Size", " to ".join(dict.fromkeys(shares)) + "%"))


def _quality(obj: bpy.types.Object):
    """The measured errors of a preview's stream; None if they are not known."""
    try:
        return quality(measured_text(obj))
    except StreamError:
        return None


def _distance(share: float, quality, scene: bpy.types.Scene) -> str:
    """A distance in 1e-4 of the size, as a length."""
    return length_text(share * 1e-4 * quality.size, scene)


def _columns(layout: bpy.types.UILayout, texts: tuple[str | None, ...]) -> bpy.types.UILayout:
    """A row of three columns; returns the layout of the one that is None, or the row."""
    first = layout.split(factor=0.34, align=True)
    second = first.column(align=True), first.split(factor=0.5, align=True)
    cells = second[0], second[1].column(align=True), second[1].column(align=True)
    place = layout
    for cell, text in zip(cells, texts, strict=True):
        if text is None:
            place = cell
        else:
            cell.alignment = "RIGHT"
            cell.label(text=text)
    return place


CLASSES = (VIEW3D_PT_npmesh_preview, VIEW3D_PT_npmesh_stops, VIEW3D_PT_npmesh_deviation, VIEW3D_PT_npmesh_play,
           VIEW3D_PT_npmesh_output)
