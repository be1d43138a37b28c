"""The settings of compression, as objects and operators have them; the numbers and their ranges are those of the core."""
import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty

from ..core.settings import AUTO, CompressSettings, LodSettings

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
