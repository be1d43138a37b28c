"""The only conversion between Blender's meshes and the core's arrays, both ways, in object space.

NumPy is imported when it is first needed, here and in the other modules that registration loads: importing it takes
longer than everything that Blender's start may wait for.
"""
from typing import TYPE_CHECKING

import bpy

if TYPE_CHECKING:
    import numpy as np

    from .core.mesh import TriMesh


SURFACES = frozenset(("MESH", "CURVE", "SURFACE", "FONT", "META"))  # types of objects that can have faces


def mesh_of(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> "TriMesh":
    """The evaluated mesh of `obj` (modifiers and shape keys applied, curves, text and metaballs as they are drawn),
    triangulated as Blender draws it.

    Returns a TriMesh in object space, in Blender units. Raises MeshError if it has no faces, is not finite, is not
    evaluated because it is disabled, or does not fit into memory.
    """
    from .core.errors import MeshError
    from .core.mesh import TriMesh

    evaluated = obj.evaluated_get(depsgraph)
    if obj.hide_viewport or not _enabled(obj, depsgraph.view_layer.layer_collection):  # then modifiers do not count
        raise MeshError(f"Expected '{obj.name}' with its modifiers evaluated, found it disabled in viewports or its "
                        "collection excluded; enable it first")
    try:
        mesh = evaluated.to_mesh()
        try:
            return TriMesh.from_arrays(*_triangles(mesh))
        finally:
            evaluated.to_mesh_clear()
    except MemoryError:
        raise MeshError("Expected a mesh that fits into memory, found too little free; "
                        "close other programs, or decimate the mesh first") from None


def _enabled(obj: bpy.types.Object, layer: bpy.types.LayerCollection) -> bool:
    """Whether `obj` is in a collection below `layer` that neither is excluded nor disabled in viewports."""
    if layer.exclude or layer.collection.hide_viewport:
        return False
    return layer.collection in obj.users_collection or any(_enabled(obj, child) for child in layer.children)


def _triangles(mesh: bpy.types.Mesh) -> "tuple[np.ndarray, np.ndarray]":
    """V (n, 3) float32 and F (m, 3) int32. Attributes are copied whole, a property of loop triangles one by one."""
    import numpy as np

    V = np.zeros((len(mesh.vertices), 3), dtype=np.float32)
    if "position" in mesh.attributes:
        mesh.attributes["position"].data.foreach_get("vector", V.reshape(-1))
    if len(mesh.loops) == 3 * len(mesh.polygons) and ".corner_vert" in mesh.attributes:
        F = np.zeros((len(mesh.polygons), 3), dtype=np.int32)
        mesh.attributes[".corner_vert"].data.foreach_get("value", F.reshape(-1))
        return V, F
    mesh.calc_loop_triangles()
    F = np.zeros((len(mesh.loop_triangles), 3), dtype=np.int32)
    mesh.loop_triangles.foreach_get("vertices", F.reshape(-1))
    return V, F


def triangle_count(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None) -> int:
    """How many triangles the evaluated mesh has, without evaluating anything; 0 where that is not known."""
    data = (obj.evaluated_get(depsgraph) if depsgraph is not None else obj).data
    return len(data.loops) - 2 * len(data.polygons) if isinstance(data, bpy.types.Mesh) else 0


def not_kept(obj: bpy.types.Object) -> str:
    """What `obj` has that its compressed mesh will not have, as a phrase; empty if there is nothing."""
    data = obj.data
    found = [(len(getattr(data, "uv_layers", ())), "UV map", "UV maps"),
             (len(getattr(data, "color_attributes", ())), "colour attribute", "colour attributes"),
             (len(obj.vertex_groups), "vertex group", "vertex groups"),
             (len(keys.key_blocks) if (keys := getattr(data, "shape_keys", None)) else 0, "shape key", "shape keys"),
             (max(len(obj.material_slots) - 1, 0), "further material", "further materials"),
             (int(getattr(data, "has_custom_normals", False)), "custom normals", "")]
    return ", ".join(f"{number} {many if number > 1 else one}" if many else one
                     for number, one, many in found if number)


def build(mesh: bpy.types.Mesh, V: "np.ndarray", F: "np.ndarray") -> None:
    """Replace the geometry of `mesh` by vertices V (n, 3) and triangles F (m, 3), shaded smooth.

    Materials and custom properties of the datablock stay.
    """
    import numpy as np

    mesh.clear_geometry()
    mesh.vertices.add(len(V))
    mesh.loops.add(F.size)
    mesh.polygons.add(len(F))
    # attributes are copied as they are; the same through `vertices` and `loops` goes one by one
    mesh.attributes["position"].data.foreach_set("vector", np.ascontiguousarray(V, dtype=np.float32).reshape(-1))
    mesh.attributes[".corner_vert"].data.foreach_set("value", np.ascontiguousarray(F, dtype=np.int32).reshape(-1))
    mesh.polygons.foreach_set("loop_start", np.arange(0, F.size, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    mesh.shade_smooth()


def write_positions(mesh: bpy.types.Mesh, V: "np.ndarray") -> None:
    """Move the vertices of `mesh` to V (n, 3) and keep everything else; n must be its vertex count."""
    import numpy as np

    mesh.attributes["position"].data.foreach_set("vector", np.ascontiguousarray(V, dtype=np.float32).reshape(-1))
    mesh.update()


def has_shape(mesh: bpy.types.Mesh, vertices: int, faces: int) -> bool:
    """Whether `mesh` still has these counts, that is, was not edited since it was built."""
    return len(mesh.vertices) == vertices and len(mesh.polygons) == faces
