"""Which object an operator means, its settings, and whether its stream is current."""
import hashlib
from typing import TYPE_CHECKING

import bpy

from ..core.errors import MeshError
from ..core.settings import CompressSettings
from ..properties import SETTING_NAMES, settings_of

if TYPE_CHECKING:
    from ..core.mesh import TriMesh


def poll_mesh(cls, context: bpy.types.Context) -> bool:
    """Whether there is a mesh object to work on; if not, the reason becomes the button's tooltip and the error."""
    obj = context.active_object
    if obj is None or not (obj.select_get() or obj.npmesh.is_preview):
        cls.poll_message_set("Expected a mesh object, found none selected; select one")
    elif obj.type != "MESH":
        cls.poll_message_set(f"Expected a mesh object, found '{obj.name}' of another type; convert it to a mesh first")
    elif obj.mode != "OBJECT":
        cls.poll_message_set(f"Expected '{obj.name}' in Object Mode, found it in another; leave that mode first")
    elif obj.library is not None:
        cls.poll_message_set(f"Expected a local object, found '{obj.name}' linked from a file; make it local first")
    else:
        return True
    return False


def poll_preview(cls, context: bpy.types.Context) -> bool:
    """Whether the active object is a preview in Object Mode."""
    obj = context.active_object
    if obj is None or not obj.npmesh.is_preview:
        cls.poll_message_set("Expected a preview, found none active; compress an object or open a file first")
    elif obj.mode != "OBJECT":
        cls.poll_message_set(f"Expected '{obj.name}' in Object Mode, found it in another; leave that mode first")
    elif obj.library is not None:
        cls.poll_message_set(f"Expected a local preview, found '{obj.name}' linked from a file; make it local first")
    else:
        return True
    return False


def source_of(obj: bpy.types.Object, view_layer: bpy.types.ViewLayer) -> bpy.types.Object:
    """The object whose mesh is compressed: the original of a preview, or the object itself.

    Raises MeshError for a preview whose original is not in the view layer, or that never had one.
    """
    if not obj.npmesh.is_preview:
        return obj
    if obj.npmesh.source is None:
        raise MeshError(f"Expected an object to compress, found '{obj.name}', which is opened from a file; "
                        "apply it first to compress it again")
    source = obj.npmesh.source
    if source.name not in view_layer.objects:
        raise MeshError(f"Expected '{source.name}', the original of '{obj.name}', in this view layer, found it "
                        "removed; bring it back, or apply the preview")
    return source


def chosen_settings(operator, obj: bpy.types.Object) -> CompressSettings:
    """The settings of `obj`, after taking over what the operator was told. Raises SettingsError.

    Base faces that the operator was told count, whatever the object had.
    """
    if operator.properties.is_property_set("base_faces"):
        obj.npmesh.auto_base = False
    for name in SETTING_NAMES:
        if operator.properties.is_property_set(name):
            setattr(obj.npmesh, name, getattr(operator, name))
    return settings_of(obj.npmesh)


def fingerprint(mesh: "TriMesh", settings: CompressSettings) -> str:
    """A name for exactly this mesh with these settings: a stream that carries it need not be made again."""
    digest = hashlib.blake2b(repr(settings).encode(), digest_size=16)
    for array in (mesh.V, mesh.F):
        digest.update(array.data)
    return digest.hexdigest()
