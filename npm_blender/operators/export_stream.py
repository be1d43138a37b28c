"""File > Export > Progressive Mesh (.npmesh): writes the compressed stream, made first if it is missing or stale."""
from pathlib import Path

import bpy
from bpy.props import BoolProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from .. import bridge, jobs, preview
from ..core.errors import FileError, NpmError
from ..core.files import SUFFIX, write_file
from ..properties import SETTING_NAMES, CompressionProperties, PresetArgument, draw_settings
from .batch import BatchOperator
from .compress import store
from .job_operator import one_line
from .target import chosen_settings, fingerprint, poll_mesh


class EXPORT_SCENE_OT_npmesh(PresetArgument, CompressionProperties, BatchOperator, bpy.types.Operator, ExportHelper):
    """Write the active mesh object as a progressive mesh; any beginning of the file already shows the whole shape"""

    bl_idname = "export_scene.npmesh"
    bl_label = "Export Progressive Mesh"
    bl_options = {"PRESET"}  # noqa: RUF012

    filename_ext = SUFFIX
    filter_glob: StringProperty(default=f"*{SUFFIX}", options={"HIDDEN"})
    only_shown: BoolProperty(
        name="Only Shown Features", options={"SKIP_SAVE"},
        description="End the file after the features that the preview uses, instead of writing all of them")

    @classmethod
    def poll(cls, context):
        if jobs.running():
            cls.poll_message_set("Expected no running job, found one; wait for it or cancel it")
            return False
        return poll_mesh(cls, context)

    def invoke(self, context, event):
        for name in SETTING_NAMES:
            setattr(self, name, getattr(context.active_object.npmesh, name))
        if not self.filepath:
            folder = Path(bpy.data.filepath).parent if bpy.data.filepath else Path()
            self.filepath = str(folder / (bpy.path.clean_name(_plain_name(context.active_object)) + SUFFIX))
        return ExportHelper.invoke(self, context, event)

    def draw(self, context):
        layout = self.layout
        layout.use_property_split, layout.use_property_decorate = True, False
        if context.active_object.npmesh.is_preview:
            layout.prop(self, "only_shown")
        else:
            draw_settings(layout, self)
        column = layout.column(align=True)
        column.label(text="Not kept: UV maps, materials,", icon="INFO")
        column.label(text="vertex groups and shape keys", icon="BLANK1")

    def execute(self, context):
        obj = context.active_object
        try:
            self._check_path()
            if obj.npmesh.is_preview:
                self._write(self._shown_part(obj))
                return {"FINISHED"}
            if self.only_shown:
                raise FileError(f"Expected a preview for Only Shown Features, found '{obj.name}'; select its preview")
            settings = chosen_settings(self, obj)
            mesh = bridge.mesh_of(obj, context.evaluated_depsgraph_get())
            if obj.npmesh.fingerprint == fingerprint(mesh, settings) and isinstance(obj.get(preview.STREAM), bytes):
                self._write(obj[preview.STREAM])
                return {"FINISHED"}
            return self.compress(context, [obj], settings, mesh)
        except (NpmError, OSError) as error:
            self.report({"ERROR"}, one_line(error))
            return {"CANCELLED"}

    def store_and_show(self, context, obj, result, made_from):
        store(obj, result, made_from)
        self._write(result.stream.data)

    def _check_path(self) -> None:
        path = Path(self.filepath)
        if path.suffix.lower() != SUFFIX:
            raise FileError(f"Expected a file name that ends in {SUFFIX}, found '{path.name}'; rename it")
        if not path.parent.is_dir():
            raise FileError(f"Expected an existing folder, found none at '{path.parent}'; create it first")

    def _shown_part(self, obj: bpy.types.Object) -> bytes:
        progressive, data = preview.progressive_of(obj), preview.received_of(obj).data
        return data[:progressive.bytes_for(obj.npmesh.features)] if self.only_shown else data

    def _write(self, data: bytes) -> None:
        write_file(Path(self.filepath), data)
        self.report({"INFO"}, f"Wrote {len(data):,} bytes to '{Path(self.filepath).name}'")


def _plain_name(obj: bpy.types.Object) -> str:
    """The name that a file of this object should have."""
    return obj.npmesh.source.name if obj.npmesh.is_preview and obj.npmesh.source else obj.name


def menu(self, context):
    """Entry of File > Export."""
    self.layout.operator(EXPORT_SCENE_OT_npmesh.bl_idname, text=f"Progressive Mesh ({SUFFIX})")


CLASSES = (EXPORT_SCENE_OT_npmesh,)
