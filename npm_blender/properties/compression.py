"""The settings of compression, as objects and operators have them; the numbers and their ranges are those of the core.

A preset is nothing but its numbers: it is what the numbers say, and setting it sets them.
"""
import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty

from ..core.settings import AUTO, LEAST_BUDGET, REFINE_STEPS, CompressSettings, LodSettings

MAX_LEVELS = 6
_LOD, _WHOLE = LodSettings(), CompressSettings()
_OPERATOR_FORGETS = {"SKIP_SAVE"}  # an operator takes what it is not told from the object, not from its last run

_COMMON = {"auto_base": False, "base_faces": _LOD.base_faces, "levels": _LOD.levels,
           "position_bits": _WHOLE.position_bits, "clean": _LOD.clean, "refine_steps": REFINE_STEPS}
PRESETS = {
    "DRAFT": ("Draft", "To see in seconds what comes out: nothing is refined", {**_COMMON, "refine_steps": 0}),
    "STANDARD": ("Standard", "Small files with good detail", _COMMON),
    "BEST": ("Best", "A finer base, and more effort to fit the file to the mesh; takes minutes",
             {**_COMMON, "base_faces": 1000, "refine_steps": 48}),
}
CUSTOM = "CUSTOM"
_LIMITED = ("auto_base", "base_faces", "levels")  # chosen where the size is limited
_PRESET_ITEMS = (*((name, label, text) for name, (label, text, _) in PRESETS.items()),
                 (CUSTOM, "Custom", "Numbers of your own: change any of them"))
_PRESET_NAMES = [item[0] for item in _PRESET_ITEMS]


def preset_of(source: "CompressionProperties") -> str:
    """The preset whose numbers `source` has, or CUSTOM."""
    for name, (_, _, numbers) in PRESETS.items():
        if all(getattr(source, key) == value for key, value in numbers.items()):
            return name
    return CUSTOM


def set_preset(source: "CompressionProperties", name: str) -> None:
    """Give `source` the numbers of a preset; CUSTOM leaves them as they are."""
    for key, value in PRESETS[name][2].items() if name != CUSTOM else ():
        setattr(source, key, value)


def _no_smaller(source: "CompressionProperties", context: bpy.types.Context) -> None:
    """Update callback of the size limit: no limit, or one that a file can keep to."""
    least = LEAST_BUDGET / 1000
    if 0 < source.size_limit < least:
        source.size_limit = least


class CompressionProperties:
    """The settings, once for objects and operators; the numbers and their ranges are those of the core."""

    size_limit: FloatProperty(
        name="Size Limit (kB)", default=0, min=0, soft_max=100, max=1e6, precision=2, step=10, options=_OPERATOR_FORGETS,
        update=_no_smaller,
        description="Fit the file into so many kilobytes, of 1000 bytes each, with the base and the levels that show most "
                    "for them. 0 sets no limit: the base is as below, and all features are kept")
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
        description="Bits for each coordinate of the base mesh, at most: fewer are used where the mesh is farther off anyway. "
                    "One bit more halves the rounding of its vertices")
    clean: EnumProperty(
        name="Cleaning", default=_LOD.clean, options=_OPERATOR_FORGETS,
        description="What to do with loose parts, overlapping faces, and edges that more than two faces share",
        items=(("auto", "Automatic", "Repair what the checks find, and report it"),
               ("off", "Off", "Compress the mesh as it is, and stop if it does not qualify"),
               ("tetwild", "Remesh", "Always rebuild the surface first; slow, for badly damaged meshes")))
    refine_steps: IntProperty(
        name="Refinement", default=REFINE_STEPS, min=0, max=10_000, soft_max=100, options=_OPERATOR_FORGETS,
        description="Effort to fit the file to this mesh, in gradient steps per stage. More of them show more detail with "
                    "the same bytes and take longer; 0 is fastest. Needs PyTorch, and is left out without it")


SETTING_NAMES = tuple(CompressionProperties.__annotations__)


class PresetProperty:
    """The preset of an object."""

    preset: EnumProperty(
        name="Preset", options=set(), items=_PRESET_ITEMS,
        get=lambda self: _PRESET_NAMES.index(preset_of(self)),
        set=lambda self, value: set_preset(self, _PRESET_NAMES[value]),
        description="How much effort goes into the file. Sets the numbers below")


class PresetArgument:
    """The preset as an operator is told it, by a script: the numbers that it is told count on top."""

    preset: EnumProperty(
        name="Preset", options={"HIDDEN", "SKIP_SAVE"}, items=_PRESET_ITEMS, default=CUSTOM,
        description="How much effort goes into the file. Sets all numbers that are not given")


def settings_of(source: CompressionProperties) -> CompressSettings:
    """The core's settings from the properties of an object or operator. Raises SettingsError."""
    limited = source.size_limit > 0
    base_faces = AUTO if limited or source.auto_base else source.base_faces
    lod = LodSettings(base_faces=base_faces, levels=AUTO if limited else source.levels, clean=source.clean)
    return CompressSettings(lod=lod, position_bits=source.position_bits, refine_steps=source.refine_steps,
                            budget=round(1000 * source.size_limit))


def draw_settings(layout: bpy.types.UILayout, source: CompressionProperties) -> None:
    """The preset, if it is an object's, and the numbers, one below the other; what another one overrules is greyed out."""
    if isinstance(source, PresetProperty):
        layout.prop(source, "preset")
    for name in SETTING_NAMES:
        row = layout.row()
        row.enabled = not (name in _LIMITED and source.size_limit > 0 or name == "base_faces" and source.auto_base)
        row.prop(source, name)
