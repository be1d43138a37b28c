"""Which objects an operator means, their settings, and whether a stream is current."""
import hashlib
from typing import TYPE_CHECKING

import bpy

from .. import bridge, preview
from ..core.errors import MeshError
from ..core.settings import CompressSettings
from ..properties import SETTING_NAMES, set_preset, settings_of

if TYPE_CHECKING:
    from ..core.mesh import TriMesh


def candidates(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The selected objects, or the active preview if nothing is selected."""
    selected, active = list(context.view_layer.objects.selected), context.view_layer.objects.active
    if selected or active is None or not active.npmesh.is_preview:
        return selected
    return [active]


def poll_selected(cls, context: bpy.types.Context) -> bool:
    """Whether a selected object can be compressed; if not, the reason becomes the button's tooltip and the error."""
    objects = candidates(context)
    if not objects:
        cls.poll_message_set("Expected a mesh object, found none selected; select one")
        return False
    reasons = [unfit(obj) for obj in objects]
    if all(reasons):
        cls.poll_message_set(reasons[0])
        return False
    return True


def poll_mesh(cls, context: bpy.types.Context) -> bool:
    """Whether the active object is one to work on; if not, the reason becomes the button's tooltip and the error."""
    obj = context.active_object
    if obj is None or not (obj.select_get() or obj.npmesh.is_preview):
        cls.poll_message_set("Expected a mesh object, found none selected; select one")
        return False
    reason = unfit(obj)
    if reason:
        cls.poll_message_set(reason)
    return not reason


def unfit(obj: bpy.types.Object) -> str:
    """Why `obj` cannot be compressed, as far as can be told without its mesh; empty if it can."""
    if obj.type == "EMPTY" and obj.instance_collection is not None:
        return f"Expected a mesh object, found '{obj.name}', an instance of a collection; make its instances real first"
    if obj.type not in bridge.SURFACES:
        return (f"Expected a mesh, curve, surface, text or metaball object, found '{obj.name}' of another type; "
                "convert it to a mesh first, or select another one")
    if obj.mode != "OBJECT":
        return f"Expected '{obj.name}' in Object Mode, found it in another; leave that mode first"
    if obj.library is not None:
        return f"Expected a local object, found '{obj.name}' linked from a file; make it local first"
    if obj.override_library is not None:
        return f"Expected a local object, found '{obj.name}', a library override; make it local first"
    return ""


def sources_of(context: bpy.types.Context) -> tuple[list[bpy.types.Object], list[str]]:
    """The objects that Compress means, each once, and why the selected others are left out, one line each.

    What can have no surface, as cameras and lights, is left out silently. Raises MeshError if no object is left.
    """
    sources, refused = [], []
    for obj in candidates(context):
        reason = unfit(obj)
        if not reason:
            try:
                source = source_of(obj, context.view_layer)
                if source not in sources:
                    sources.append(source)
                continue
            except MeshError as error:
                reason = str(error)
        elif obj.type not in bridge.SURFACES and obj.instance_type != "COLLECTION":
            continue
        refused.append(reason)
    if not sources:
        raise MeshError(refused[0] if refused else "Expected a mesh object, found none selected; select one")
    return sources, refused


def poll_preview(cls, context: bpy.types.Context) -> bool:
    """Whether the active object is a preview in Object Mode."""
    obj = context.active_object
    if obj is None or not obj.npmesh.is_preview:
        cls.poll_message_set("Expected a preview, found none active; compress an object or open a file first")
    elif obj.mode != "OBJECT":
        cls.poll_message_set(f"Expected '{obj.name}' in Object Mode, found it in another; leave that mode first")
    elif reason := preview.foreign(obj):
        cls.poll_message_set(reason)
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

    A preset sets all numbers, then those that the operator was told. Base faces and levels that it was told count,
    whatever the object had.
    """
    set_preset(obj.npmesh, operator.preset)
    if any(map(operator.properties.is_property_set, ("base_faces", "levels"))):
        obj.npmesh.size_limit = 0
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
