"""Where preview and original stand: one in place of the other, or beside each other."""
import bpy
from mathutils import Vector

GAP = 0.1  # between the two, of their width
# What places an object; copied one by one, as a matrix would change the numbers that the user typed
TRANSFORM = ("parent", "parent_type", "parent_bone", "matrix_parent_inverse", "rotation_mode", "location",
             "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale", "delta_location",
             "delta_rotation_euler", "delta_rotation_quaternion", "delta_scale")


def put_in_place(obj: bpy.types.Object, source: bpy.types.Object) -> None:
    """Give `obj` the place of `source`."""
    for name in TRANSFORM:
        setattr(obj, name, getattr(source, name))
    if source.constraints:
        obj.matrix_world = source.matrix_world


def get_show_original(state) -> bool:
    """Whether the original is on the screen in place of the preview."""
    source = state.source
    return _is_there(source) and not source.hide_get() and not state.beside


def set_show_original(state, shown: bool) -> None:
    """Swap the original and the preview on the screen; both stay where they are, and the preview stays active."""
    if _is_there(state.source) and _is_there(state.id_data):
        if state.beside:
            state.beside = False
        state.source.hide_set(not shown)
        state.id_data.hide_set(shown)


def on_beside(state, context: bpy.types.Context) -> None:
    """Update callback: both side by side along the world's x, or the preview back in the place of the original."""
    obj, source = state.id_data, state.source
    if not (state.is_preview and _is_there(source) and _is_there(obj)):
        return
    obj.hide_set(False)
    source.hide_set(not state.beside)
    put_in_place(obj, source)
    if state.beside:
        context.view_layer.update()
        _move(obj, Vector(((1 + GAP) * _width(source), 0, 0)))


def _is_there(obj: bpy.types.Object | None) -> bool:
    return obj is not None and obj.name in bpy.context.view_layer.objects


def _width(obj: bpy.types.Object) -> float:
    """Extent along the world's x."""
    at = [(obj.matrix_world @ Vector(corner)).x for corner in obj.bound_box]
    return max(at) - min(at)


def _move(obj: bpy.types.Object, offset: Vector) -> None:
    """Move `obj` by an offset in world space; its rotation and scale keep their numbers."""
    parent = obj.matrix_world @ obj.matrix_basis.inverted_safe()
    obj.location += parent.to_3x3().inverted_safe() @ offset
