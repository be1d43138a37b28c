"""A set of levels of detail as ordinary objects, named as game engines expect them."""
from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy

from .. import bridge
from ..core.errors import SettingsError
from . import placement, smooth
from .streams import progressive_of

if TYPE_CHECKING:
    from ..core.codec import ProgressiveMesh

GAP = 0.1  # between levels that stand side by side, of their width
NAME, LEVEL = "{name}", "{level}"
LONGEST_NAME = 63  # bytes that a name has in Blender


@dataclass(frozen=True)
class Convention:
    """pattern: of the names; group: name of the empty above the levels, none without one; marks: its custom properties."""

    label: str
    description: str
    pattern: str
    group: str = ""
    marks: tuple[tuple[str, str], ...] = ()


# Unreal's and Unity's rules are those of their FBX importers. Godot has none for levels.
CONVENTIONS = {
    "PLAIN": Convention("Plain", "Name_LOD0, Name_LOD1 and so on, side by side in a collection", "{name}_LOD{level}"),
    "UNREAL": Convention("Unreal Engine", "SM_Name_LOD0 and so on under an empty that FBX marks as an LOD group",
                         "SM_{name}_LOD{level}", "SM_{name}", (("fbx_type", "LodGroup"),)),
    "UNITY": Convention("Unity", "Name_LOD0 and so on under an empty, of which Unity's importer makes an LOD Group",
                        "{name}_LOD{level}", "{name}_LODs"),
    "GODOT": Convention("Godot", "name_lod0 and so on, in Godot's lower case; ranges of visibility are set in its editor",
                        "{name}_lod{level}"),
    "CUSTOM": Convention("Custom", "A pattern of your own", ""),
}
ITEMS = tuple((key, c.label, c.description) for key, c in CONVENTIONS.items())


def names(pattern: str, name: str, count: int, taken: set[str]) -> list[str]:
    """Names of the levels, the finest first. Raises SettingsError if they would not be as the pattern says."""
    if LEVEL not in pattern:
        raise SettingsError(f"Expected {LEVEL} in the pattern of names, found '{pattern}'; put it where the number goes")
    found = [pattern.replace(NAME, name).replace(LEVEL, str(k)) for k in range(count)]
    for one in found:
        if len(one.encode()) > LONGEST_NAME:
            raise SettingsError(f"Expected names of at most {LONGEST_NAME} bytes, found '{one}'; choose a shorter pattern")
        if one in taken:
            raise SettingsError(f"Expected '{one}' to be free, found an object of that name; rename or remove it, "
                                "or choose another pattern")
    return found


def make(obj: bpy.types.Object, name: str, convention: Convention, pattern: str, features: int,
         side_by_side: bool) -> list[bpy.types.Object]:
    """Objects of all levels of a preview, the finest first, in a new collection beside it.

    Raises SettingsError for names that are not free, StreamError and others as `progressive_of`.
    """
    progressive = progressive_of(obj)
    group = convention.group.replace(NAME, name)
    called = names(pattern, name, progressive.levels + 1, set(bpy.data.objects.keys()))
    if group in bpy.data.objects:
        raise SettingsError(f"Expected '{group}' to be free, found an object of that name; rename or remove it")
    collection = bpy.data.collections.new(f"{name}_LODs")
    parent = next((c for c in obj.users_collection), bpy.context.scene.collection)
    parent.children.link(collection)
    top = _group(obj, group, convention, collection) if group else None
    made = []
    for k, level in enumerate(reversed(range(progressive.levels + 1))):
        made.append(_level(obj, progressive, level, features, called[k], collection))
        if top is not None:
            made[-1].parent = top
        else:
            placement.put_in_place(made[-1], obj)
        if side_by_side:
            made[-1].location.x += k * (1 + GAP) * obj.dimensions.x
    return made


def _level(obj: bpy.types.Object, progressive: "ProgressiveMesh", level: int, features: int, name: str,
           collection: bpy.types.Collection) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    bridge.build(mesh, progressive.decode_positions(features, level), progressive.level_faces(level, features))
    smooth.write(mesh, obj.npmesh.shading, obj.npmesh.smooth_angle)
    for material in obj.data.materials:
        mesh.materials.append(material)
    made = bpy.data.objects.new(name, mesh)
    collection.objects.link(made)
    return made


def _group(obj: bpy.types.Object, name: str, convention: Convention,
           collection: bpy.types.Collection) -> bpy.types.Object:
    """The empty above the levels, in the place of the preview."""
    top = bpy.data.objects.new(name, None)
    for key, value in convention.marks:
        top[key] = value
    placement.put_in_place(top, obj)
    collection.objects.link(top)
    return top
