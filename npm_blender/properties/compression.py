"""The settings of compression, as objects and operators have them; the numbers and their ranges are those of the core.

A preset is nothing but its numbers: it is what the numbers say, and setting it sets them.
"""
from collections.abc import Callable

import bpy
from bpy.props import EnumProperty, FloatProperty, IntProperty

from ..core.settings import (
    AUTO,
    DISPLACED,
    LEAST_BUDGET,
    PAPER,
    PAPER_FACES,
    PAPER_LEVELS,
    CompressSettings,
    LodSettings,
)

MAX_LEVELS = 6
LEAST_FACES, LEAST_BITS = 4, 4
_LOD, _WHOLE = LodSettings(), CompressSettings()
_OPERATOR_FORGETS = {"SKIP_SAVE"}  # an operator takes what it is not told from the object, not from its last run

_COMMON = {"model": DISPLACED, "base_faces": AUTO, "levels": AUTO, "position_bits": AUTO, "clean": _LOD.clean}
PRESETS = {
    "DRAFT": ("Draft", "To see sooner what comes out: a small base, and no fine detail",
              {**_COMMON, "base_faces": 400, "levels": 2}),
    "STANDARD": ("Standard", "Base and levels that suit the mesh", _COMMON),
    "PAPER": ("Paper", "The method of the paper as it was published: latents and a network, over 400 faces and 3 levels",
              {**_COMMON, "model": PAPER, "base_faces": PAPER_FACES, "levels": PAPER_LEVELS}),
}
CUSTOM = "CUSTOM"
_LIMITED = ("base_faces", "levels")  # chosen where the size of a displaced surface is limited
_AUTOMATIC = ("base_faces", "levels", "position_bits")  # 0: the core chooses
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


def _none_or(name: str, least: int) -> Callable[["CompressionProperties", bpy.types.Context], None]:
    """Update callback of a number that is 0, or at least so much."""
    def mend(source: "CompressionProperties", context: bpy.types.Context) -> None:
        if 0 < getattr(source, name) < least:
            setattr(source, name, least)

    return mend


class CompressionProperties:
    """The settings, once for objects and operators; the numbers and their ranges are those of the core."""

    model: EnumProperty(
        name="Model", default=_WHOLE.model, options=_OPERATOR_FORGETS,
        description="How the surface between the vertices of the base is told",
        items=((DISPLACED, "Displaced surface", "A smooth surface over a base that is fitted to the mesh, then how far each "
                                                "vertex lies off it"),
               (PAPER, "Paper", "Numbers for faces, of which a trained network makes the surface")))
    size_limit: FloatProperty(
        name="Size Limit (kB)", default=0, min=0, soft_max=100, max=1e6, precision=2, step=10, options=_OPERATOR_FORGETS,
        update=_no_smaller,
        description="Fit the file into so many kilobytes, of 1000 bytes each, with the base and the levels that show most "
                    "for them. 0 sets no limit: the file has all detail that helps")
    base_faces: IntProperty(
        name="Base Faces", default=_LOD.base_faces, min=AUTO, max=100_000, soft_max=4000, options=_OPERATOR_FORGETS,
        update=_none_or("base_faces", LEAST_FACES),
        description="Triangles of the coarsest level, which is sent first and whole. More of them keep thin parts and "
                    "holes better, and make the smallest possible file larger. 0 chooses their number")
    levels: IntProperty(
        name="Levels", default=_LOD.levels, min=AUTO, max=MAX_LEVELS, options=_OPERATOR_FORGETS,
        description="How often the base is subdivided. Each level has four times the faces of the one before, and can "
                    "show finer detail. 0 chooses what suits base and mesh")
    position_bits: IntProperty(
        name="Precision", default=_WHOLE.position_bits, min=AUTO, max=20, options=_OPERATOR_FORGETS,
        update=_none_or("position_bits", LEAST_BITS),
        description="Bits for each coordinate of the base mesh. One bit more halves the rounding of its vertices. 0 takes as "
                    "many as the error of the base asks for")
    clean: EnumProperty(
        name="Cleaning", default=_LOD.clean, options=_OPERATOR_FORGETS,
        description="What to do with loose parts, overlapping faces, and edges that more than two faces share",
        items=(("auto", "Automatic", "Repair what the checks find, and report it"),
               ("off", "Off", "Compress the mesh as it is, and stop if it does not qualify"),
               ("tetwild", "Remesh", "Always rebuild the surface first; slow, for badly damaged meshes")))


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
    told = {name: AUTO if _overruled(source, name) else getattr(source, name) for name in _LIMITED}
    return CompressSettings(lod=LodSettings(**told, clean=source.clean), position_bits=source.position_bits,
                            model=source.model, budget=round(1000 * source.size_limit))


def _overruled(source: CompressionProperties, name: str) -> bool:
    """Whether a number does not count, because the size limit chooses it."""
    return name in _LIMITED and source.size_limit > 0 and source.model == DISPLACED


def draw_settings(layout: bpy.types.UILayout, source: CompressionProperties) -> None:
    """The preset, if it is an object's, and the numbers, one below the other; what another one overrules is greyed out."""
    if isinstance(source, PresetProperty):
        layout.prop(source, "preset")
    for name in SETTING_NAMES:
        row = layout.row()
        overruled = _overruled(source, name)
        row.enabled = not overruled
        if name in _AUTOMATIC and (overruled or getattr(source, name) == AUTO):
            label = CompressionProperties.__annotations__[name].keywords["name"]  # the bl_rna of an operator does not have them
            row.prop(source, name, text=f"{label} (Automatic)")
        else:
            row.prop(source, name)
