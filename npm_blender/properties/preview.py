"""The state of a preview: what its stream is, what of it is shown, and what the panel says of it.

Numbers that panels draw are stored: drawing never decodes.

After a property with an update callback Blender draws every area of every window again, and evaluates the object once
more. What a user drags is therefore got and set by functions, kept in a property of its own (`kept_..`), and only what
shows it is drawn.
"""
import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from ..preview import deviation, placement, slider, smooth, updates

MOST_LEVELS = 8  # that a stream may have, more than compressing offers
# what a path that may begin with // must say of itself, since there is a word for it
_RELATIVE = {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5, 0) else set()


class NpmLevelMesh(bpy.types.PropertyGroup):
    """The mesh of one level of a preview; none until the level is first shown."""

    mesh: PointerProperty(type=bpy.types.Mesh, description="The mesh of this level")
    faces: IntProperty(description="Faces of this level with the features that are used")


class PreviewProperties:
    """The part of `Object.npmesh` that belongs to previews."""

    # Set once, when the preview is made
    is_preview: BoolProperty(description="Whether this object shows a compressed stream")
    digest: StringProperty(description="Names the stream")
    filepath: StringProperty(
        name="File", subtype="FILE_PATH", options=_RELATIVE, update=updates.on_path,
        description="File of a stream that is not packed in the .blend; // means the folder of the .blend")
    source: PointerProperty(type=bpy.types.Object, description="The compressed object; none for an opened file")
    meshes: CollectionProperty(type=NpmLevelMesh, description="One mesh for each level")
    level_count: IntProperty(description="Levels above the base")
    total_features: IntProperty(description="Features that the stream promises")
    arrived_features: IntProperty(description="Features that are there; fewer if the file was cut off or is damaged")
    shortfall: StringProperty(description="What is wrong with a stream that was cut off or is damaged")
    stream_bytes: IntProperty(description="Bytes of the stream as it is")
    base_bytes: IntProperty(description="Bytes of the stream up to the end of the base mesh")
    later_bases: StringProperty(description="From which byte to which each later base of the stream arrives")
    arrived_bytes: IntProperty(description="Bytes of the stream up to the last feature that is there")
    source_bytes: IntProperty(description="Bytes of the original as a binary PLY file")
    source_faces: IntProperty(description="Faces of the original")
    shading: EnumProperty(
        items=smooth.SHADINGS, default="SMOOTH", options=set(), description="How the faces of the levels are shaded")
    smooth_angle: FloatProperty(
        subtype="ANGLE", options=set(), description="Edges of the levels that are sharper than this are drawn sharp")

    # What is shown, set by the user
    features: IntProperty(
        name="Features", min=0, options=set(),
        get=lambda self: self.kept_features, set=lambda self, value: updates.set_features(self, value),
        description="How many features are used, in the order in which they are sent. A feature is a number that moves one "
                    "vertex along its normal; of the paper's model, eight numbers that bend one face")
    level: EnumProperty(
        name="Level", options=set(),
        get=lambda self: self.kept_level, set=lambda self, value: updates.set_level(self, value),
        description="Subdivision level that is shown",
        items=tuple((str(k), str(k), f"Base subdivided {k} times, {4 ** k} times its faces" if k else "Base mesh")
                    for k in range(MOST_LEVELS + 1)))
    detail: FloatProperty(
        name="Detail", subtype="PERCENTAGE", min=0, max=100, precision=1, options=set(),
        get=lambda self: slider.get_detail(self), set=lambda self, value: slider.set_detail(self, value),
        description="How much of the stream is used, from the base alone to all. Equal steps multiply the bytes by equal "
                    "factors, and so take away equal shares of the error")
    budget: FloatProperty(
        name="Budget (kB)", min=0, soft_max=1000, precision=2, step=10, options=set(),
        get=lambda self: slider.get_budget(self), set=lambda self, value: slider.set_budget(self, value),
        description="Use as many features as fit into this many kilobytes, of 1000 bytes each, with the base mesh")
    show_original: BoolProperty(
        name="Show Original", options=set(),
        get=lambda self: placement.get_show_original(self),
        set=lambda self, value: placement.set_show_original(self, value),
        description="Show the original in place of the preview, to compare the two")
    beside: BoolProperty(
        name="Beside", options=set(), update=lambda self, context: placement.on_beside(self, context),
        description="Show the preview beside the original instead of in its place")
    show_deviation: BoolProperty(
        name="Deviation", options=set(), update=deviation.on_toggle,
        description="Colour the preview by its distance to the original, as that is now; the colour attribute is called "
                    f"{deviation.ATTRIBUTE}, and solid viewports show attributes meanwhile")
    deviation_top: FloatProperty(
        name="Red At", subtype="DISTANCE", min=0, precision=4, options=set(), update=deviation.on_scale,
        description="Distance to the original at which the colours end, in units of the object. 0 chooses one from what "
                    "is shown")
    play_rate: FloatProperty(
        name="Line (kbit/s)", default=64, min=0.1, soft_max=10_000, max=10_000_000, precision=1, options=set(),
        description="Speed of the line over which the stream is played, in thousands of bits per second")

    # What the user set
    kept_features: IntProperty(min=0, options=set(), description="How many features are used")
    kept_level: IntProperty(min=0, max=MOST_LEVELS, options=set(), description="Subdivision level that is shown")

    kept_detail: FloatProperty(description="The detail that was set last, as a percentage")

    # What is on the screen now, for the panel
    detail_features: IntProperty(default=-1, description="The features that the detail gave")
    budget_bytes: IntProperty(description="The budget that was set last")
    budget_features: IntProperty(default=-1, description="The features that it paid for")
    shown_bytes: IntProperty(description="Bytes of the stream up to the last feature that is used")
    shown_faces: IntProperty(description="Faces of the level that is shown")
    deviation_mean: FloatProperty(description="Mean distance of the shown vertices to the original")
    deviation_max: FloatProperty(description="Largest distance of a shown vertex to the original")
    problem: StringProperty(description="Why the preview cannot be shown")
    deviation_problem: StringProperty(description="Why the deviation cannot be shown")
