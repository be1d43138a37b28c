"""How a preview begins and ends: make it, give it another stream, keep it as an ordinary object, drop it."""
from typing import TYPE_CHECKING

import bpy

from . import decoder_cache, deviation, levels, placement, smooth, storage

if TYPE_CHECKING:
    from ..core.codec import StoredStream


def find(source: bpy.types.Object, view_layer: bpy.types.ViewLayer) -> bpy.types.Object | None:
    """The preview of `source` in this view layer, if it has one."""
    return next((o for o in view_layer.objects if o.npmesh.is_preview and o.npmesh.source == source), None)


def set_stream(obj: bpy.types.Object, received: "StoredStream") -> None:
    """Make `obj`, a mesh object, the preview of a stream and show all of it at the finest level.

    Raises StreamError, WeightsError or DependencyError, and then leaves the object as it was.
    """
    progressive = decoder_cache.progressive_in(received)
    digest = storage.digest_of(received.data)
    state = obj.npmesh
    old = levels.level_meshes(obj)
    if state.source is not None:
        state.shading, state.smooth_angle = smooth.read(state.source)
    storage.pack(obj, received)
    state.is_preview = False  # no updates before all is set
    state.digest, state.level_count = digest, progressive.levels
    state.total_features, state.arrived_features = progressive.total_features, progressive.features
    state.shortfall = progressive.shortfall
    state.stream_bytes, state.base_bytes = progressive.total_bytes, progressive.base_bytes
    state.later_bases = " ".join(f"{rung.begin}-{rung.bytes}" for rung in progressive.rungs[1:])
    state.arrived_bytes = progressive.bytes_for(progressive.features)
    state.detail_features = state.budget_features = -1
    state.source_bytes = ply_bytes(progressive.source_vertices, progressive.source_faces)
    state.source_faces = progressive.source_faces
    state.features, state.level = progressive.features, str(progressive.levels)
    state.meshes.clear()
    for _ in range(progressive.levels + 1):
        state.meshes.add()
    state.is_preview = True
    levels.show(obj)
    levels.remove_unused(old)
    deviation.forget(obj)  # the original may have changed
    deviation.request(obj)


def make(context: bpy.types.Context, received: "StoredStream", name: str,
         source: bpy.types.Object | None) -> bpy.types.Object:
    """A new preview object of a stream, in place of `source`, which is hidden, if there is one.

    It becomes selected and active, except while another object is edited or sculpted.
    Raises StreamError, WeightsError or DependencyError, and then leaves nothing behind.
    """
    mesh = bpy.data.meshes.new(name)
    obj = bpy.data.objects.new(name, mesh)
    try:
        material = None if source is None else main_material(source)
        if material is not None:
            mesh.materials.append(material)
        obj.npmesh.source = source
        set_stream(obj, received)
    except BaseException:
        bpy.data.objects.remove(obj)
        raise
    finally:
        levels.remove_unused([mesh])
    for collection in (source.users_collection if source else ()) or (context.collection,):
        collection.objects.link(obj)
    space = context.space_data
    if space is not None and space.type == "VIEW_3D" and space.local_view:
        obj.local_view_set(space, True)
    if source is not None:
        placement.put_in_place(obj, source)
        obj.npmesh.report = source.npmesh.report
        source.hide_set(True)
    if context.mode != "OBJECT":
        return obj
    for other in context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj
    return obj


def apply(obj: bpy.types.Object) -> None:
    """Make a preview an ordinary mesh object that holds what it shows now."""
    deviation.end(obj)
    meshes = levels.level_meshes(obj)
    obj.npmesh.meshes.clear()
    levels.remove_unused(meshes)
    if levels.STAMP in obj.data:
        del obj.data[levels.STAMP]
    storage.unpack(obj)
    obj.property_unset("npmesh")


def discard(obj: bpy.types.Object, view_layer: bpy.types.ViewLayer) -> None:
    """Remove a preview and bring back the object that it was made from."""
    deviation.end(obj)
    source = obj.npmesh.source
    meshes = levels.level_meshes(obj)
    bpy.data.objects.remove(obj)
    levels.remove_unused(meshes)
    if source is not None and source.name in view_layer.objects:
        source.hide_set(False)
        source.select_set(True)
        view_layer.objects.active = source


def main_material(obj: bpy.types.Object) -> bpy.types.Material | None:
    """The material of most faces of an object; the decoded faces are others, so they get one for all."""
    import numpy as np

    index = obj.data.attributes.get("material_index") if isinstance(obj.data, bpy.types.Mesh) else None
    if len(obj.material_slots) < 2 or index is None or index.domain != "FACE" or not len(index.data):
        return obj.material_slots[0].material if obj.material_slots else None
    slots = np.zeros(len(index.data), dtype=np.int32)
    index.data.foreach_get("value", slots)
    most = int(np.bincount(np.clip(slots, 0, len(obj.material_slots) - 1)).argmax())
    return obj.material_slots[most].material


def ply_bytes(vertices: int, faces: int) -> int:
    """Size of a mesh as a binary PLY file without its header: 12 bytes a vertex, 13 a triangle."""
    return 12 * vertices + 13 * faces
