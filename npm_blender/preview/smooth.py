"""Shading of the levels as of the original: flat, smooth, or smooth with edges beyond an angle drawn sharp.

Since Blender 4.1 the angle is either in the modifier Smooth by Angle or has become marks on edges. Marks that an angle
explains give the angle back; those that were set by hand have no counterpart on other edges and are not carried over.
"""
import math

import bpy

SHADINGS = (("SMOOTH", "Smooth", "All edges are drawn smooth"),
            ("ANGLE", "Smooth by Angle", "Edges are drawn sharp beyond an angle"),
            ("FLAT", "Flat", "All edges are drawn sharp"))
MODIFIER = "Smooth by Angle"
TOLERANCE = math.radians(0.5)  # edges this close to the angle may be on either side of it


def read(source: bpy.types.Object) -> tuple[str, float]:
    """Shading of a mesh object, one of SHADINGS, and the angle in radians (0 without one)."""
    mesh = source.data
    if not isinstance(mesh, bpy.types.Mesh):
        return "SMOOTH", 0.0
    for modifier in source.modifiers:
        if modifier.type == "NODES" and modifier.show_viewport and modifier.node_group is not None:
            if modifier.node_group.name.partition(".")[0] == MODIFIER:
                return "ANGLE", _angle_of(modifier)
    if _share(mesh, "sharp_face") > 0.5:
        return "FLAT", 0.0
    angle = _angle_of_marks(mesh) if _share(mesh, "sharp_edge") else None
    return ("SMOOTH", 0.0) if angle is None else ("ANGLE", angle)


def write(mesh: bpy.types.Mesh, shading: str, angle: float) -> None:
    """Shade a level's mesh, after its vertices have moved."""
    if shading == "ANGLE":
        mesh.set_sharp_from_angle(angle=angle)
    elif shading == "FLAT" and "sharp_face" not in mesh.attributes:
        mesh.shade_flat()


def _angle_of(modifier: bpy.types.Modifier) -> float:
    for item in modifier.node_group.interface.items_tree:
        if item.item_type == "SOCKET" and item.in_out == "INPUT" and item.name == "Angle":
            inputs = getattr(getattr(modifier, "properties", None), "inputs", None)
            if inputs is None:  # before Blender 5.2
                return float(modifier.get(item.identifier, item.default_value))
            return float(getattr(inputs, item.identifier).value)
    return math.radians(30)  # what Blender's own operator starts with


def _share(mesh: bpy.types.Mesh, name: str) -> float:
    """Share of the elements for which the boolean attribute `name` is set."""
    import numpy as np

    attribute = mesh.attributes.get(name)
    if attribute is None or attribute.data_type != "BOOLEAN" or not len(attribute.data):
        return 0.0
    values = np.zeros(len(attribute.data), dtype=bool)
    attribute.data.foreach_get("value", values)
    return float(values.mean())


def _angle_of_marks(mesh: bpy.types.Mesh) -> float | None:
    """The angle that tells the edges marked sharp from the others, if there is one."""
    import numpy as np

    faces, loops = len(mesh.polygons), len(mesh.loops)
    sharp, edge = np.zeros(len(mesh.edges), dtype=bool), np.zeros(loops, dtype=np.int32)
    count, normal = np.zeros(faces, dtype=np.int32), np.zeros((faces, 3), dtype=np.float32)
    mesh.attributes["sharp_edge"].data.foreach_get("value", sharp)
    mesh.loops.foreach_get("edge_index", edge)
    mesh.polygons.foreach_get("loop_total", count)
    mesh.polygons.foreach_get("normal", normal.reshape(-1))
    order = np.argsort(edge, kind="stable")
    face = np.repeat(np.arange(faces), count)[order]
    at = np.searchsorted(edge[order], np.arange(len(sharp)))
    inner = np.flatnonzero(np.bincount(edge, minlength=len(sharp)) == 2)
    cosine = (normal[face[at[inner]]] * normal[face[at[inner] + 1]]).sum(1)
    angle = np.arccos(np.clip(cosine, -1, 1))
    marked = sharp[inner]
    if not marked.any():
        return None
    low, high = float(angle[~marked].max(initial=0.0)), float(angle[marked].min())
    return None if low > high + TOLERANCE else max((low + high) / 2, 0.0)
