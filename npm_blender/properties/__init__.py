"""What an object remembers: how to compress it, and, for a preview, what of its stream is shown.

Everything lives in `Object.npmesh`, so it is saved, copied and undone with the object. The stream itself is packed
beside it as a custom property of bytes (`preview.STREAM`).
"""
import bpy
from bpy.props import StringProperty

from .compression import (
    SETTING_NAMES,
    CompressionProperties,
    PresetArgument,
    PresetProperty,
    draw_settings,
    set_preset,
    settings_of,
)
from .preview import NpmLevelMesh, PreviewProperties


class NpmObject(PresetProperty, CompressionProperties, PreviewProperties, bpy.types.PropertyGroup):
    """`Object.npmesh`: settings of any mesh object, its compressed result, and the state of a preview."""

    # The compressed result; on the compressed object and on its preview
    fingerprint: StringProperty(description="Of the mesh and the settings that the stream was made from")
    report: StringProperty(description="What compressing changed or could not reach, one line each")


CLASSES = (NpmLevelMesh, NpmObject)

__all__ = ["CLASSES", "SETTING_NAMES", "CompressionProperties", "NpmObject", "PresetArgument", "draw_settings",
           "set_preset", "settings_of"]
