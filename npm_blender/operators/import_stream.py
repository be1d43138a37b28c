"""File > Import > Progressive Mesh (.npmesh), and files dropped on a viewport or the outliner."""
from pathlib import Path

import bpy
from bpy.props import BoolProperty, CollectionProperty, StringProperty
from bpy_extras.io_utils import ImportHelper, poll_file_object_drop

from .. import jobs, preview
from ..core.errors import NpmError
from ..core.files import SUFFIX
from ..preferences import worker_settings
from ..preview.opening import receive
from .job_operator import JobOperator, one_line


class IMPORT_SCENE_OT_npmesh(JobOperator, bpy.types.Operator, ImportHelper):
    """Open progressive meshes; a file that was cut off or is damaged opens to what has arrived"""

    bl_idname = "import_scene.npmesh"
    bl_label = "Import Progressive Mesh"
    bl_options = {"UNDO"}  # noqa: RUF012

    filter_glob: StringProperty(default=f"*{SUFFIX}", options={"HIDDEN"})
    filepath: StringProperty(subtype="FILE_PATH", options={"HIDDEN", "SKIP_SAVE"})  # set: the file is dropped
    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})
    link: BoolProperty(
        name="Link Files", options={"SKIP_SAVE"},
        description="Keep only the path and checksum of each file in the .blend, instead of packing its stream")

    def invoke(self, context, event):
        dropped = self.files or self.properties.is_property_set("filepath")
        if dropped or context.mode != "OBJECT":  # there is nothing to ask
            return self.execute(context)
        return ImportHelper.invoke(self, context, event)

    def draw(self, context):
        self.layout.prop(self, "link")

    def execute(self, context):
        if context.mode != "OBJECT":  # no poll: of a drop that poll refuses, Blender says nothing
            self.report({"ERROR"}, "Expected Object Mode, found another; leave that mode first")
            return {"CANCELLED"}
        names = [f.name for f in self.files if f.name]
        self._paths = [Path(self.directory, name) for name in names] if names else [Path(self.filepath)]
        if self.blocks():
            return self.run_steps(context, self.finish(context, [_received(path) for path in self._paths]))
        try:
            return self.run_job(context, jobs.ReadJob(self._paths, bpy.app.tempdir, worker_settings()))
        except (NpmError, OSError) as error:
            self.report({"ERROR"}, one_line(error))
            return {"CANCELLED"}

    def doing(self):
        return f"Opening '{self._paths[0].name}'" if len(self._paths) == 1 else f"Opening {len(self._paths)} files"

    def finish(self, context, result):
        opened = []
        for path, received in zip(self._paths, result, strict=True):
            try:
                if isinstance(received, NpmError):
                    raise received
                yield from preview.open_ahead(received)
                obj = preview.make(context, received, path.stem, None)
                if self.link:
                    preview.link(obj, path)
                opened.append(obj.session_uid)
                if obj.npmesh.shortfall:
                    self.report({"WARNING"}, f"'{path.name}' {obj.npmesh.shortfall}")
            except NpmError as error:
                self.report({"ERROR"}, f"'{path.name}': {one_line(error)}")
            yield
        if context.mode == "OBJECT":
            for obj in [o for o in context.view_layer.objects if o.session_uid in opened]:
                obj.select_set(True)
        return {"FINISHED"} if opened else {"CANCELLED"}


def _received(path: Path):
    """What jobs.ReadJob would give for one file, in this process."""
    from ..core.files import read_file

    try:
        return receive(read_file(path))
    except NpmError as error:
        return error


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
