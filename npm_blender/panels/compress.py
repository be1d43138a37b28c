"""The panel of compression: settings, Compress, the progress of a running job, the report."""
import bpy

from .. import jobs, preview
from ..operators.compress import OBJECT_OT_npmesh_cancel, OBJECT_OT_npmesh_compress
from ..operators.decoded import OBJECT_OT_npmesh_preview
from ..properties import draw_settings
from .common import Sidebar, lines


class VIEW3D_PT_npmesh_compress(Sidebar, bpy.types.Panel):
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
                lines(layout, line, "INFO", context.region.width)


CLASSES = (VIEW3D_PT_npmesh_compress,)
