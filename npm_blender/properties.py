"""What an object remembers: how to compress it, and, for a preview, what of its stream is shown.

Everything lives in `Object.npmesh`, so it is saved, copied and undone with the object. The stream itself is packed
beside it as a custom property of bytes (`preview.STREAM`). Numbers that panels draw are stored: drawing never decodes.
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

from . import preview
from .core.settings import AUTO, CompressSettings, LodSettings

MAX_LEVELS = 6
_LOD, _WHOLE = LodSettings(), CompressSettings()
_OPERATOR_FORGETS = {"SKIP_SAVE"}  # an operator takes what it is not told from the object, not from its last run


class CompressionProperties:
    """The settings, once for objects and operators; the numbers and their ranges are those of the core."""

    auto_base: BoolProperty(
        name="Automatic Base", default=False, options=_OPERATOR_FORGETS,
        description="Choose the faces of the base from the shape: few for a smooth shape, up to 2,000 for one full of detail, "
                    "handles or parts")
    base_faces: IntProperty(
        name="Base Faces", default=_LOD.base_faces, min=4, max=100_000, soft_min=100, soft_max=4000,
        options=_OPERATOR_FORGETS,
        description="Triangles of the coarsest level, which is sent first and whole. More of them keep thin parts and "
                    "holes better, and make the smallest possible file larger")
    levels: IntProperty(
        name="Levels", default=_LOD.levels, min=1, max=MAX_LEVELS, options=_OPERATOR_FORGETS,
        description="How often the base is subdivided. Each level has four times the faces of the one before, and can "
                    "show finer detail")
    position_bits: IntProperty(
        name="Precision", default=_WHOLE.position_bits, min=9, max=14, options=_OPERATOR_FORGETS,
        description="Bits for each coordinate of the base mesh. One bit more halves the rounding of its vertices")
    clean: EnumProperty(
        name="Cleaning", default=_LOD.clean, options=_OPERATOR_FORGETS,
        description="What to do with loose parts, overlapping faces, and edges that more than two faces share",
        items=(("auto", "Automatic", "Repair what the checks find, and report it"),
               ("off", "Off", "Compress the mesh as it is, and stop if it does not qualify"),
               ("tetwild", "Remesh", "Always rebuild the surface first; slow, for badly damaged meshes")))


SETTING_NAMES = tuple(CompressionProperties.__annotations__)


def settings_of(source: CompressionProperties) -> CompressSettings:
    """The core's settings from the properties of an object or operator. Raises SettingsError."""
    base_faces = AUTO if source.auto_base else source.base_faces
    lod = LodSettings(base_faces=base_faces, levels=source.levels, clean=source.clean)
    return CompressSettings(lod=lod, position_bits=source.position_bits)


def draw_settings(layout: bpy.types.UILayout, source: CompressionProperties) -> None:
    """All settings, one below the other; what another one overrules is greyed out."""
    for name in SETTING_NAMES:
        row = layout.row()
        row.enabled = name != "base_faces" or not source.auto_base
        row.prop(source, name)


class NpmLevelMesh(bpy.types.PropertyGroup):
    """The mesh of one level of a preview; none until the level is first shown."""

    mesh: PointerProperty(type=bpy.types.Mesh)


class NpmObject(CompressionProperties, bpy.types.PropertyGroup):
    """`Object.npmesh`: settings of any mesh object, its compressed result, and the state of a preview."""

    # The compressed result; on the compressed object and on its preview
    fingerprint: StringProperty(description="Of the mesh and the settings that the stream was made from")
    report: StringProperty(description="What compressing changed or could not reach, one line each")

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


CLASSES = (NpmLevelMesh, NpmObject)
