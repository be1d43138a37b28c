"""File > Import > Progressive Mesh (.npmesh), and files dropped on a viewport or the outliner."""
from pathlib import Path

import bpy
from bpy.props import CollectionProperty, StringProperty
from bpy_extras.io_utils import ImportHelper, poll_file_object_drop

from .. import preview
from ..core.errors import NpmError
from .export_stream import SUFFIX
from .job_operator import one_line


class IMPORT_SCENE_OT_npmesh(bpy.types.Operator, ImportHelper):
    """Open progressive meshes; a file that was cut off opens to what has arrived"""

    bl_idname = "import_scene.npmesh"
    bl_label = "Import Progressive Mesh"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    filter_glob: StringProperty(default=f"*{SUFFIX}", options={"HIDDEN"})
    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        if context.mode != "OBJECT":
            cls.poll_message_set("Expected Object Mode, found another; leave that mode first")
            return False
        return True

    def invoke(self, context, event):
        return self.invoke_popup(context)

    def draw(self, context):
        """Nothing to set: how a mesh was compressed is in its file."""

    def execute(self, context):
        names = [f.name for f in self.files if f.name]
        paths = [Path(self.directory, name) for name in names] if names else [Path(self.filepath)]
        from ..cli.files import check_input

        opened = []
        for path in paths:
            try:
                opened.append(preview.make(context, check_input(path).read_bytes(), path.stem, None))
            except (NpmError, OSError) as error:
                self.report({"ERROR"}, f"'{path.name}': {one_line(error)}")
                continue
            state = opened[-1].npmesh
            if state.arrived_features < state.total_features:
                self.report({"WARNING"}, f"'{path.name}' ends early: opened with {state.arrived_features:,} of "
                                         f"{state.total_features:,} features")
        for obj in opened:
            obj.select_set(True)
        return {"FINISHED"} if opened else {"CANCELLED"}


class IO_FH_npmesh(bpy.types.FileHandler):
    """Opens files that are dropped."""

    bl_idname = "IO_FH_npmesh"
    bl_label = "Progressive Mesh"
    bl_import_operator = IMPORT_SCENE_OT_npmesh.bl_idname
    bl_file_extensions = SUFFIX

    @classmethod
    def poll_drop(cls, context):
        return poll_file_object_drop(context)


def menu(self, context):
    """Entry of File > Import."""
    self.layout.operator(IMPORT_SCENE_OT_npmesh.bl_idname, text=f"Progressive Mesh ({SUFFIX})")


CLASSES = (IMPORT_SCENE_OT_npmesh, IO_FH_npmesh)
