"""The meshes of a preview's levels, brought to what its properties say."""
import bpy

from .. import bridge
from . import smooth
from .streams import progressive_of

STAMP = "npmesh_shown"  # custom property of a level's mesh: stream, rung and number of features that it holds


def show(obj: bpy.types.Object) -> bool:
    """Bring the mesh of a preview to its level and number of features; returns whether anything was decoded.

    Raises StreamError, FileError, WeightsError or DependencyError.
    """
    state, progressive = obj.npmesh, progressive_of(obj)
    level, features = min(int(state.level), progressive.levels), min(state.features, progressive.features)
    mesh = _level_mesh(obj, level)
    of_rung = f"{state.digest}:{progressive.rung_at(features)}"
    stamp, stale = f"{of_rung}:{features}", False
    F = progressive.level_faces(level, features)
    if mesh.get(STAMP) != stamp:
        stale = True
        V = progressive.decode_positions(features, level)
        if str(mesh.get(STAMP)).rpartition(":")[0] == of_rung and bridge.has_shape(mesh, len(V), len(F)):
            bridge.write_positions(mesh, V)
        else:
            bridge.build(mesh, V, F)
        smooth.write(mesh, state.shading, state.smooth_angle)
        mesh[STAMP] = stamp
    if obj.data != mesh:
        obj.data = mesh
    for k, item in enumerate(state.meshes):
        item.faces = progressive.faces_at(k, features)
    state.shown_faces, state.shown_bytes, state.problem = len(F), progressive.bytes_for(features), ""
    return stale


def is_shown(obj: bpy.types.Object) -> bool:
    """Whether the object's mesh is what its properties say, as far as the stamp tells."""
    state, mesh = obj.npmesh, obj.data
    level = int(state.level)
    of_stream, _, features = str(mesh.get(STAMP)).rpartition(":")
    return (of_stream.startswith(f"{state.digest}:") and features == str(state.features)
            and level < len(state.meshes) and state.meshes[level].mesh == mesh)


def level_meshes(obj: bpy.types.Object) -> list[bpy.types.Mesh]:
    """The meshes of the levels that were shown so far."""
    return [item.mesh for item in obj.npmesh.meshes if item.mesh is not None]


def remove_unused(meshes: list[bpy.types.Mesh]) -> None:
    """Remove those that nobody uses."""
    for mesh in meshes:
        if mesh.users == 0:
            bpy.data.meshes.remove(mesh)


def _level_mesh(obj: bpy.types.Object, level: int) -> bpy.types.Mesh:
    """The datablock of a level, of this object alone, with the materials of the mesh that is shown."""
    state = obj.npmesh
    item = state.meshes[level]
    owned = 1 + (obj.data == item.mesh)  # users: the list, and the object that shows it
    if (item.mesh is None or item.mesh.library is not None
            or item.mesh.users - item.mesh.use_fake_user > owned):  # a copied object shares its meshes
        item.mesh = bpy.data.meshes.new(f"{obj.name} L{level}")
    materials = list(obj.data.materials)
    if list(item.mesh.materials) != materials:
        item.mesh.materials.clear()
        for material in materials:
            item.mesh.materials.append(material)
    return item.mesh
