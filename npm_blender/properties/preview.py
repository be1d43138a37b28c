"""The state of a preview: what its stream is, what of it is shown, and what the panel says of it.

Numbers that panels draw are stored: drawing never decodes.
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

from .. import preview
from .compression import MAX_LEVELS


class NpmLevelMesh(bpy.types.PropertyGroup):
    """The mesh of one level of a preview; none until the level is first shown."""

    mesh: PointerProperty(type=bpy.types.Mesh)


class PreviewProperties:
    """The part of `Object.npmesh` that belongs to previews."""

    # A preview: set once, when it is made
    is_preview: BoolProperty()
    digest: StringProperty(description="Names the packed stream")
    source: PointerProperty(type=bpy.types.Object, description="The compressed object; none for an opened file")
    meshes: CollectionProperty(type=NpmLevelMesh)
    level_count: IntProperty(description="Levels above the base")
    total_features: IntProperty(description="Features that the stream promises")
    arrived_features: IntProperty(description="Features that are there; fewer if the file was cut off")
    stream_bytes: IntProperty(description="Bytes of the stream as it is")
    source_bytes: IntProperty(description="Bytes of the original as a binary PLY file")
    source_faces: IntProperty(description="Faces of the original")

    # A preview: what it shows, set by the user
    features: IntProperty(
        name="Features", min=0, options=set(), update=preview.on_change,
        description="How many features are used, in the order in which they are sent. A feature is a handful of "
                    "numbers that tell one face of one level how to bend")
    level: EnumProperty(
        name="Level", default="0", options=set(), update=preview.on_change,
        description="Subdivision level that is shown",
        items=tuple((str(k), str(k), f"Base subdivided {k} times, {4 ** k} times its faces" if k else "Base mesh")
                    for k in range(MAX_LEVELS + 1)))
    detail: FloatProperty(
        name="Detail", subtype="PERCENTAGE", min=0, max=100, precision=1, options=set(),
        get=lambda self: preview.get_detail(self), set=lambda self, value: preview.set_detail(self, value),
        description="How much of the stream is used, the most important features first. Finer at the start, where each "
                    "feature changes most")
    show_original: BoolProperty(
        name="Show Original", options=set(),
        get=lambda self: preview.get_show_original(self),
        set=lambda self, value: preview.set_show_original(self, value),
        description="Show the original in place of the preview, to compare the two")

    # A preview: what is on the screen now, for the panel
    shown_bytes: IntProperty(description="Bytes of the stream up to the last feature that is used")
    shown_faces: IntProperty(description="Faces of the level that is shown")
    problem: StringProperty(description="Why the preview cannot be shown")
