"""The panel of compression: the running job, preset and numbers, Compress, and the report."""
import bpy

from .. import jobs, preview
from ..core.errors import SettingsError
from ..jobs import estimate
from ..operators.compress import OBJECT_OT_npmesh_cancel, OBJECT_OT_npmesh_compress
from ..operators.decoded import OBJECT_OT_npmesh_preview
from ..operators.expected_time import expected_seconds, rates
from ..operators.target import candidates, unfit
from ..properties import draw_settings, settings_of
from .common import Sidebar, lines


class VIEW3D_PT_npmesh_compress(Sidebar, bpy.types.Panel):
    """Settings, Compress, and the progress of a running job."""

    bl_label = "Progressive Compression"

    def draw(self, context):
        layout, obj, width = self.layout, context.active_object, context.region.width
        for job in jobs.running():
            _progress(layout, job)
        selected = [o for o in candidates(context) if not unfit(o)]
        if obj is None or obj not in selected:
            obj = selected[0] if selected else obj
        source = obj.npmesh.source if obj is not None and obj.npmesh.is_preview else obj
        if source is None or unfit(source):
            layout.label(text="Opened from a file" if obj and obj.npmesh.is_preview else "Select a mesh object")
            return
        settings = layout.column()
        settings.use_property_split, settings.use_property_decorate = True, False
        draw_settings(settings, source.npmesh)
        if not jobs.running():
            _buttons(layout, context, obj, source, selected)
        if source.npmesh.report:
            box = layout.box().column(align=True)
            box.label(text=f"Report on {source.name}")
            for line in source.npmesh.report.splitlines():
                lines(box, line, "DOT", width)


def _progress(layout: bpy.types.UILayout, job: jobs.Job) -> None:
    """What the job does, its bar, the time that is left, and the way to end it."""
    box = layout.box().column(align=True)
    box.label(text=job.doing)
    row = box.row(align=True)
    row.progress(factor=job.fraction, text=f"{job.message}  {100 * job.fraction:.0f}%")
    row.operator(OBJECT_OT_npmesh_cancel.bl_idname, text="", icon="X")
    left = job.seconds_left()
    if left is not None:
        box.label(text=f"About {estimate.text(left)} left")


def _buttons(layout: bpy.types.UILayout, context: bpy.types.Context, obj: bpy.types.Object, source: bpy.types.Object,
             selected: list[bpy.types.Object]) -> None:
    """Compress, with how long it will take, and Show Preview."""
    again = isinstance(source.get(preview.STREAM), bytes)
    several = len(selected) > 1
    text = f"Compress {len(selected)} Objects" if several else "Compress Again" if again else "Compress"
    button = layout.column(align=True)
    big = button.row()
    big.scale_y = 1.4
    big.operator(OBJECT_OT_npmesh_compress.bl_idname, text=text)
    sources = [o.npmesh.source or o for o in selected] or [source]
    try:
        seconds = rates().start + sum(expected_seconds(sources, settings_of(source.npmesh), context.view_layer.depsgraph))
    except SettingsError:
        return  # numbers of a newer version; the operator says so
    button.label(text=f"Takes about {estimate.text(seconds)}", icon="TIME")
    if again and not obj.npmesh.is_preview and not several:
        layout.operator(OBJECT_OT_npmesh_preview.bl_idname, text="Show Preview", icon="HIDE_OFF")


CLASSES = (VIEW3D_PT_npmesh_compress,)
