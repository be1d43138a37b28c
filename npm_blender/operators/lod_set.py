"""Make a set of levels of detail from a preview: one object for each level, named for an engine."""
import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ..core.errors import NpmError
from ..preview import lodset
from .job_operator import one_line
from .preview_operator import PreviewOperator


class OBJECT_OT_npmesh_lod_set(PreviewOperator, bpy.types.Operator):
    """Make an ordinary object of every level, the finest as LOD0, in a collection of their own"""

    bl_idname = "object.npmesh_lod_set"
    bl_label = "Make LOD Set"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012 - Blender's own form

    name: StringProperty(
        name="Name", options={"SKIP_SAVE"}, description="What {name} in the pattern stands for; empty for the original's")
    convention: EnumProperty(
        name="Names For", items=lodset.ITEMS, default="PLAIN", description="Engine whose names the objects get")
    pattern: StringProperty(
        name="Pattern", default=lodset.CONVENTIONS["PLAIN"].pattern,
        description="Names of the objects, with {name} and {level}; used with Custom")
    features: EnumProperty(
        name="Features", default="SHOWN", description="How many features the levels get",
        items=(("SHOWN", "As Shown", "The features that the slider is at"),
               ("ALL", "All", "Every feature that has arrived")))
    side_by_side: BoolProperty(
        name="Side by Side", description="Move the levels apart along x, to look at them; engines want them in one place")

    def invoke(self, context, event):
        self.name = self._plain_name(context.active_object)
        return context.window_manager.invoke_props_dialog(self, width=340)

    def draw(self, context):
        layout = self.layout
        layout.use_property_split, layout.use_property_decorate = True, False
        layout.prop(self, "name")
        layout.prop(self, "convention")
        row = layout.row()
        row.active = self.convention == "CUSTOM"
        row.prop(self, "pattern")
        layout.prop(self, "features")
        layout.prop(self, "side_by_side")

    def execute(self, context):
        obj, convention = context.active_object, lodset.CONVENTIONS[self.convention]
        state = obj.npmesh
        features = state.features if self.features == "SHOWN" else state.arrived_features
        name = self.name or self._plain_name(obj)
        if self.convention == "GODOT":
            name = name.lower().replace(" ", "_")
        try:
            made = lodset.make(obj, name, convention, convention.pattern or self.pattern, features, self.side_by_side)
        except NpmError as error:
            self.report({"ERROR"}, one_line(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"Made {len(made)} levels, '{made[0].name}' to '{made[-1].name}'")
        return {"FINISHED"}

    def _plain_name(self, obj):
        return obj.npmesh.source.name if obj.npmesh.source is not None else obj.name


CLASSES = (OBJECT_OT_npmesh_lod_set,)
