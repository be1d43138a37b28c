"""The only conversion between Blender's meshes and the core's arrays, both ways, in object space.

NumPy is imported when it is first needed, here and in the other modules that registration loads: importing it takes
longer than everything that Blender's start may wait for.
"""
from typing import TYPE_CHECKING

import bpy

if TYPE_CHECKING:
    import numpy as np

    from .core.mesh import TriMesh


def mesh_of(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> "TriMesh":
    """The evaluated mesh of `obj` (modifiers applied), triangulated as Blender draws it.

    Returns a TriMesh in object space, in Blender units. Raises MeshError if it has no faces or is not finite.
    """
    import numpy as np

    from .core.mesh import TriMesh

    evaluated = obj.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh()
    try:
        V = np.zeros((len(mesh.vertices), 3), dtype=np.float32)
        mesh.vertices.foreach_get("co", V.reshape(-1))
        mesh.calc_loop_triangles()
        F = np.zeros((len(mesh.loop_triangles), 3), dtype=np.int32)
        mesh.loop_triangles.foreach_get("vertices", F.reshape(-1))
    finally:
        evaluated.to_mesh_clear()
    return TriMesh.from_arrays(V, F)


def build(mesh: bpy.types.Mesh, V: "np.ndarray", F: "np.ndarray") -> None:
    """Replace the geometry of `mesh` by vertices V (n, 3) and triangles F (m, 3), shaded smooth.

    Materials and custom properties of the datablock stay.
    """
    import numpy as np

    mesh.clear_geometry()
    mesh.vertices.add(len(V))
    mesh.loops.add(F.size)
    mesh.polygons.add(len(F))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(V, dtype=np.float32).reshape(-1))
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(F, dtype=np.int32).reshape(-1))
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
