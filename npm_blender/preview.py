"""Previews: objects whose mesh is decoded from a packed stream and follows the level and the number of features.

A level's mesh is built once; another level swaps `obj.data`, another number of features only moves vertices. Decoders
are kept by the digest of their stream, never by object, and what a mesh holds is stamped on the mesh: after undo, redo
or loading, comparing stamp and properties says what is still to do.
"""
import hashlib
import time
from collections import OrderedDict
from typing import TYPE_CHECKING

import bpy

from . import bridge
from .core.errors import NpmError, StreamError
from .dependencies import open_received, receive

if TYPE_CHECKING:
    from .core.progressive import ProgressiveMesh
    from .core.received import Received

STREAM = "npmesh_stream"  # custom property of an object: the packed bytes
ARRAYS = "npmesh_arrays"  # what was read from them, so that they open without compiled code
STAMP = "npmesh_shown"  # custom property of a level's mesh: stream and number of features that it holds
KEPT_DECODERS = 8
# What places an object; copied one by one, as a matrix would change the numbers that the user typed
TRANSFORM = ("parent", "parent_type", "parent_bone", "matrix_parent_inverse", "rotation_mode", "location",
             "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale", "delta_location",
             "delta_rotation_euler", "delta_rotation_quaternion", "delta_scale")
# An update that takes longer than a frame or two waits for the timer, so that a dragged slider stays under the mouse.
FAST_SECONDS, TIMER_SECONDS = 0.03, 0.03
# Detail d uses the share d ** DETAIL_POWER of all features: the first hundred change more than the next thousand.
DETAIL_POWER = 3

_decoders: OrderedDict = OrderedDict()
_seconds: dict[str, float] = {}  # what the last update of a stream took
_waiting: set[int] = set()  # session_uid of objects that the timer will update


def find(source: bpy.types.Object, view_layer: bpy.types.ViewLayer) -> bpy.types.Object | None:
    """The preview of `source` in this view layer, if it has one."""
    return next((o for o in view_layer.objects if o.npmesh.is_preview and o.npmesh.source == source), None)


def pack(obj: bpy.types.Object, received: "Received") -> None:
    """Keep a stream on an object.

    A property that exists is removed first: assigned over another, bytes end at their first zero (Blender 4.5, 5.2).
    """
    unpack(obj)
    obj[STREAM], obj[ARRAYS] = received.data, received.arrays


def unpack(obj: bpy.types.Object) -> None:
    """Remove what `pack` kept."""
    for name in (STREAM, ARRAYS):
        if name in obj:
            del obj[name]


def packed(obj: bpy.types.Object) -> "Received | None":
    """The stream that is kept on an object, if there is one. Raises StreamError or DependencyError if it is damaged."""
    from .core.received import Received

    data, arrays = obj.get(STREAM), obj.get(ARRAYS)
    if not isinstance(data, bytes):
        return None
    return Received(data, arrays) if isinstance(arrays, bytes) else receive(data)


def decoder_of(obj: bpy.types.Object) -> "ProgressiveMesh":
    """The opened stream of a preview. Raises StreamError, WeightsError or DependencyError."""
    digest = obj.npmesh.digest
    if digest not in _decoders:
        received = packed(obj)
        if received is None:
            raise StreamError(f"Expected the compressed stream in '{obj.name}', found none; open the file again")
        _decoders[digest] = open_received(received)
        while len(_decoders) > KEPT_DECODERS:
            _decoders.popitem(last=False)
    _decoders.move_to_end(digest)
    return _decoders[digest]


def set_stream(obj: bpy.types.Object, received: "Received") -> None:
    """Make `obj`, a mesh object, the preview of a stream and show all of it at the finest level.

    Raises StreamError, WeightsError or DependencyError, and then leaves the object as it was.
    """
    decoder = open_received(received)
    digest = hashlib.blake2b(received.data, digest_size=16).hexdigest()
    state = obj.npmesh
    old = _level_meshes(obj)
    _decoders[digest] = decoder
    pack(obj, received)
    state.is_preview = False  # no updates before all is set
    state.digest, state.level_count = digest, decoder.levels
    state.total_features, state.arrived_features = decoder.total_features, decoder.features
    state.stream_bytes = decoder.total_bytes
    state.source_bytes = ply_bytes(decoder.source_vertices, decoder.source_faces)
    state.source_faces = decoder.source_faces
    state.features, state.level = decoder.features, str(decoder.levels)
    state.meshes.clear()
    for _ in range(decoder.levels + 1):
        state.meshes.add()
    state.is_preview = True
    show(obj)
    _remove_unused(old)


def make(context: bpy.types.Context, received: "Received", name: str,
         source: bpy.types.Object | None) -> bpy.types.Object:
    """A new preview object of a stream, in place of `source`, which is hidden, if there is one.

    It becomes selected and active, except while another object is edited or sculpted.
    Raises StreamError, WeightsError or DependencyError, and then leaves nothing behind.
    """
    mesh = bpy.data.meshes.new(name)
    obj = bpy.data.objects.new(name, mesh)
    try:
        if source is not None and source.active_material is not None:
            mesh.materials.append(source.active_material)
        set_stream(obj, received)
    except BaseException:
        bpy.data.objects.remove(obj)
        raise
    finally:
        _remove_unused([mesh])
    for collection in (source.users_collection if source else ()) or (context.collection,):
        collection.objects.link(obj)
    space = context.space_data
    if space is not None and space.type == "VIEW_3D" and space.local_view:
        obj.local_view_set(space, True)
    if source is not None:
        for name in TRANSFORM:
            setattr(obj, name, getattr(source, name))
        if source.constraints:
            obj.matrix_world = source.matrix_world
        obj.npmesh.source = source
        obj.npmesh.report = source.npmesh.report
        source.hide_set(True)
    if context.mode != "OBJECT":
        return obj
    for other in context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj
    return obj


def show(obj: bpy.types.Object) -> None:
    """Bring the mesh of a preview to its level and number of features; does nothing if it is there already.

    Raises StreamError, WeightsError or DependencyError.
    """
    start = time.perf_counter()
    state, decoder = obj.npmesh, decoder_of(obj)
    level, features = min(int(state.level), decoder.levels), min(state.features, decoder.features)
    mesh = _level_mesh(obj, level)
    stamp = f"{state.digest}:{features}"
    V, F = None, decoder.level_faces(level)
    if mesh.get(STAMP) != stamp:
        V = decoder.decode_positions(features, level)
        if bridge.has_shape(mesh, len(V), len(F)):
            bridge.write_positions(mesh, V)
        else:
            bridge.build(mesh, V, F)
        mesh[STAMP] = stamp
    if obj.data != mesh:
        obj.data = mesh
    state.shown_faces, state.shown_bytes, state.problem = len(F), decoder.bytes_for(features), ""
    if V is not None:
        _seconds[state.digest] = time.perf_counter() - start


def _level_mesh(obj: bpy.types.Object, level: int) -> bpy.types.Mesh:
    """The datablock of a level, of this object alone, with the materials of the mesh that is shown."""
    state = obj.npmesh
    item = state.meshes[level]
    owned = 1 + (obj.data == item.mesh)  # users: the list, and the object that shows it
    if item.mesh is None or item.mesh.users - item.mesh.use_fake_user > owned:  # a copied object shares its meshes
        item.mesh = bpy.data.meshes.new(f"{obj.name} L{level}")
    materials = list(obj.data.materials)
    if list(item.mesh.materials) != materials:
        item.mesh.materials.clear()
        for material in materials:
            item.mesh.materials.append(material)
    return item.mesh


def on_change(state, context: bpy.types.Context) -> None:
    """Update callback of the level and the number of features: clamp, then show now or from the timer."""
    obj = state.id_data
    if not state.is_preview or obj.mode != "OBJECT":
        return
    if state.features > state.arrived_features:
        state.features = state.arrived_features  # calls this function again
        return
    if int(state.level) > state.level_count:
        state.level = str(state.level_count)
        return
    if bpy.app.background or _seconds.get(state.digest, 0.0) <= FAST_SECONDS:
        _show_or_say(obj)
        return
    _waiting.add(obj.session_uid)
    if not bpy.app.timers.is_registered(flush):
        bpy.app.timers.register(flush, first_interval=TIMER_SECONDS)


def flush() -> None:
    """Show what waits for the timer."""
    uids = set(_waiting)
    _waiting.clear()
    for obj in [o for o in bpy.data.objects if o.session_uid in uids] if uids else []:
        if obj.npmesh.is_preview and obj.mode == "OBJECT":
            _show_or_say(obj)


def _show_or_say(obj: bpy.types.Object) -> None:
    """`show` where no operator could report: the panel says what is wrong."""
    try:
        show(obj)
    except NpmError as error:
        obj.npmesh.problem = str(error)


@bpy.app.handlers.persistent
def refresh_all(*_args: object) -> None:
    """After undo and redo, and before saving: every preview shows what its properties say."""
    _waiting.clear()
    for obj in [o for o in bpy.data.objects if o.npmesh.is_preview and o.library is None and o.mode == "OBJECT"]:
        mesh = obj.data
        if mesh.get(STAMP) != f"{obj.npmesh.digest}:{obj.npmesh.features}" or not _is_level(obj, mesh):
            _show_or_say(obj)


def _is_level(obj: bpy.types.Object, mesh: bpy.types.Mesh) -> bool:
    level = int(obj.npmesh.level)
    return level < len(obj.npmesh.meshes) and obj.npmesh.meshes[level].mesh == mesh


@bpy.app.handlers.persistent
def forget_all(*_args: object) -> None:
    """Drop decoders and pending updates: another file is being loaded, or the extension is being disabled."""
    _waiting.clear()
    _decoders.clear()
    _seconds.clear()
    if bpy.app.timers.is_registered(flush):
        bpy.app.timers.unregister(flush)


def apply(obj: bpy.types.Object) -> None:
    """Make a preview an ordinary mesh object that holds what it shows now."""
    levels = _level_meshes(obj)
    obj.npmesh.meshes.clear()
    _remove_unused(levels)
    if STAMP in obj.data:
        del obj.data[STAMP]
    unpack(obj)
    obj.property_unset("npmesh")


def discard(obj: bpy.types.Object, view_layer: bpy.types.ViewLayer) -> None:
    """Remove a preview and bring back the object that it was made from."""
    source = obj.npmesh.source
    levels = _level_meshes(obj)
    bpy.data.objects.remove(obj)
    _remove_unused(levels)
    if source is not None and source.name in view_layer.objects:
        source.hide_set(False)
        source.select_set(True)
        view_layer.objects.active = source


def _level_meshes(obj: bpy.types.Object) -> list[bpy.types.Mesh]:
    return [item.mesh for item in obj.npmesh.meshes if item.mesh is not None]


def _remove_unused(meshes: list[bpy.types.Mesh]) -> None:
    for mesh in meshes:
        if mesh.users == 0:
            bpy.data.meshes.remove(mesh)


def ply_bytes(vertices: int, faces: int) -> int:
    """Size of a mesh as a binary PLY file without its header: 12 bytes a vertex, 13 a triangle."""
    return 12 * vertices + 13 * faces


def get_detail(state) -> float:
    """The number of features as a percentage that is fine at the start; see DETAIL_POWER."""
    return 100 * (state.features / max(state.total_features, 1)) ** (1 / DETAIL_POWER)


def set_detail(state, percent: float) -> None:
    """The inverse of `get_detail`."""
    state.features = round(state.total_features * (percent / 100) ** DETAIL_POWER)


def get_show_original(state) -> bool:
    """Whether the original is on the screen."""
    source = state.source
    return source is not None and source.name in bpy.context.view_layer.objects and not source.hide_get()


def set_show_original(state, shown: bool) -> None:
    """Swap the original and the preview on the screen; both stay where they are, and the preview stays active."""
    objects = bpy.context.view_layer.objects
    if state.source is not None and state.source.name in objects and state.id_data.name in objects:
        state.source.hide_set(not shown)
        state.id_data.hide_set(shown)
