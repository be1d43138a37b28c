"""Export what a preview shows as glTF, through Blender's own exporter."""
from pathlib import Path

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper

from .. import preview
from ..core.errors import DependencyError, FileError, NpmError
from .job_operator import one_line
from .target import poll_preview

SUFFIXES = (".glb", ".gltf")


class EXPORT_SCENE_OT_npmesh_gltf(bpy.types.Operator, ExportHelper):
    """Export the level that the preview shows, with its features and material, as an ordinary glTF file"""

    bl_idname = "export_scene.npmesh_gltf"
    bl_label = "Export Decoded Level as glTF"
    bl_options = {"REGISTER"}  # noqa: RUF012 - Blender's own form

    filename_ext = ".glb"
    filter_glob: StringProperty(default="*.glb;*.gltf", options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        if not has_exporter():
            cls.poll_message_set("Expected Blender's glTF exporter, found it switched off; enable glTF 2.0 format under "
                                 "Preferences > Add-ons")
            return False
        return poll_preview(cls, context)

    def check(self, context):
        """Called by the file browser: .gltf stays, other names get .glb."""
        if self.filepath.lower().endswith(SUFFIXES):
            return False
        return ExportHelper.check(self, context)

    def execute(self, context):
        obj = context.active_object
        try:
            if not self.filepath.lower().endswith(SUFFIXES):
                raise FileError(f"Expected a file name that ends in .glb or .gltf, found '{self.filepath}'; rename it")
            folder = Path(self.filepath).parent
            if not folder.is_dir():  # Blender's exporter would make it, or fail with a traceback
                raise FileError(f"Expected an existing folder, found none at '{folder}'; create it first")
            preview.show(obj)
            _export(context, obj, self.filepath)
        except NpmError as error:
            self.report({"ERROR"}, one_line(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"Wrote {obj.npmesh.shown_faces:,} faces to '{bpy.path.basename(self.filepath)}'")
        return {"FINISHED"}


def has_exporter() -> bool:
    """Whether the add-on that brings Blender's glTF exporter is enabled."""
    return hasattr(bpy.types, "EXPORT_SCENE_OT_gltf")


def _export(context: bpy.types.Context, obj: bpy.types.Object, path: str) -> None:
    """Export `obj` alone; raises DependencyError or FileError with what the exporter said."""
    if not has_exporter():
        raise DependencyError("Expected Blender's glTF exporter, found it switched off; enable glTF 2.0 format under "
                              "Preferences > Add-ons")
    selected, hidden = list(context.selected_objects), obj.hide_get()
    coloured = obj.npmesh.show_deviation
    obj.npmesh.show_deviation = False
    obj.hide_set(False)
    for other in selected:
        other.select_set(False)
    obj.select_set(True)
    try:
        kind = "GLB" if path.lower().endswith(".glb") else "GLTF_SEPARATE"
        bpy.ops.export_scene.gltf(filepath=path, export_format=kind, use_selection=True, export_extras=False,
                                  export_animations=False)
    except RuntimeError as error:
        raise FileError(f"Expected Blender's glTF exporter to write {path}, found: {error}; "
                        "check the folder's permissions and space") from None
    finally:
        obj.select_set(False)
        for other in selected:
            other.select_set(True)
        obj.hide_set(hidden)
        if coloured:
            obj.npmesh.show_deviation = True


CLASSES = (EXPORT_SCENE_OT_npmesh_gltf,)
