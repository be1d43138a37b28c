"""Where the stream of a preview is kept: linked from a file, or packed in the .blend; and what to do if the file changed."""
from pathlib import Path

import bpy
from bpy_extras.io_utils import ExportHelper

from .. import preview
from ..core.errors import FileError, NpmError
from ..core.files import SUFFIX, read_file, write_file
from .job_operator import one_line
from .preview_operator import PreviewOperator


class StorageOperator(PreviewOperator):
    """An operator on where the active preview's stream is kept; what goes wrong becomes one line."""

    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012 - Blender's own form

    def execute(self, context):
        try:
            self.change(context.active_object)
        except NpmError as error:
            self.report({"ERROR"}, one_line(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class OBJECT_OT_npmesh_link(StorageOperator, bpy.types.Operator, ExportHelper):
    """Write the stream to a file and keep only its path and checksum in the .blend"""

    bl_idname = "object.npmesh_link"
    bl_label = "Link to File"

    filename_ext = SUFFIX
    filter_glob: bpy.props.StringProperty(default=f"*{SUFFIX}", options={"HIDDEN"})

    def invoke(self, context, event):
        obj = context.active_object
        folder = Path(bpy.data.filepath).parent if bpy.data.filepath else Path()
        self.filepath = str(folder / (bpy.path.clean_name((obj.npmesh.source or obj).name) + SUFFIX))
        return ExportHelper.invoke(self, context, event)

    def change(self, obj):
        path = Path(self.filepath)
        if path.suffix.lower() != SUFFIX:
            raise FileError(f"Expected a file name that ends in {SUFFIX}, found '{path.name}'; rename it")
        data = preview.received_of(obj).data
        if not (path.is_file() and read_file(path) == data):
            write_file(path, data)
        preview.link(obj, path)
        if obj.npmesh.source is not None:
            preview.unpack(obj.npmesh.source)  # or the .blend would hold it still
        self.report({"INFO"}, f"Linked {obj.npmesh.filepath}, {len(data):,} bytes")


class OBJECT_OT_npmesh_pack(StorageOperator, bpy.types.Operator):
    """Take the stream from its file into the .blend"""

    bl_idname = "object.npmesh_pack"
    bl_label = "Pack into .blend"

    def change(self, obj):
        preview.pack(obj, preview.received_of(obj))


class OBJECT_OT_npmesh_reload(StorageOperator, bpy.types.Operator):
    """Take the stream that is in the linked file now, whether or not it is the one that was linked"""

    bl_idname = "object.npmesh_reload"
    bl_label = "Reload File"

    def change(self, obj):
        if not preview.is_linked(obj):
            raise FileError(f"Expected a linked file in '{obj.name}', found its stream packed; there is nothing to reload")
        path = preview.path_of(obj)
        preview.set_stream(obj, preview.read_anew(path))
        preview.link(obj, path)


CLASSES = (OBJECT_OT_npmesh_link, OBJECT_OT_npmesh_pack, OBJECT_OT_npmesh_reload)
