"""LOD sets: every level as an ordinary object, named as an engine wants it."""
import bpy
import numpy as np
import pytest

from .conftest import positions, refusal


def make(obj, **arguments):
    bpy.context.view_layer.objects.active = obj
    assert bpy.ops.object.npmesh_lod_set(**arguments) == {"FINISHED"}


def check(part, obj, shown, level, features):
    V = part("preview").progressive_of(shown).decode_positions(features, level)
    assert np.array_equal(positions(obj), V.astype(np.float32))
    assert len(obj.data.polygons) == 80 * 4**level
    assert not obj.npmesh.is_preview and "npmesh_shown" not in obj.data and "npmesh_stream" not in obj


def test_every_level_in_a_collection(part, previewed):
    previewed.location, previewed.rotation_euler = (1, 2, 3), (0.1, 0.2, 0.3)
    previewed.npmesh.features = 20
    previewed.data.materials.append(bpy.data.materials.new("Clay"))
    make(previewed)
    collection = bpy.data.collections["Shape_LODs"]
    assert [o.name for o in collection.objects] == ["Shape_LOD0", "Shape_LOD1", "Shape_LOD2"]
    bpy.context.view_layer.update()
    for k, obj in enumerate(collection.objects):
        check(part, obj, previewed, 2 - k, 20)
        assert obj.matrix_world == previewed.matrix_world and [m.name for m in obj.data.materials] == ["Clay"]
        assert obj.data.name == obj.name
    assert previewed.npmesh.is_preview


def test_all_features(part, previewed):
    previewed.npmesh.features = 0
    make(previewed, features="ALL")
    check(part, bpy.data.objects["Shape_LOD0"], previewed, 2, previewed.npmesh.arrived_features)


@pytest.mark.parametrize(("convention", "names", "group"), [
    ("UNREAL", ["SM_Shape_LOD0", "SM_Shape_LOD1", "SM_Shape_LOD2"], "SM_Shape"),
    ("UNITY", ["Shape_LOD0", "Shape_LOD1", "Shape_LOD2"], "Shape_LODs"),
    ("GODOT", ["shape_lod0", "shape_lod1", "shape_lod2"], None)])
def test_names_and_groups_of_engines(previewed, convention, names, group):
    previewed.location = (1, 2, 3)
    make(previewed, convention=convention)
    bpy.context.view_layer.update()
    for name in names:
        obj = bpy.data.objects[name]
        assert (obj.parent.name if obj.parent else None) == group
        assert obj.matrix_world.translation == previewed.matrix_world.translation
    if convention == "UNREAL":
        assert bpy.data.objects[group]["fbx_type"] == "LodGroup"


def test_a_pattern_of_ones_own(previewed):
    make(previewed, name="rock", convention="CUSTOM", pattern="env.{name}.{level}.x")
    assert {"env.rock.0.x", "env.rock.1.x", "env.rock.2.x"} <= set(bpy.data.objects.keys())


def test_side_by_side(previewed):
    make(previewed, side_by_side=True)
    at = [o.location.x for o in bpy.data.collections["Shape_LODs"].objects]
    assert np.diff(at).min() > previewed.dimensions.x


def test_a_pattern_without_a_level(previewed):
    message = refusal(bpy.ops.object.npmesh_lod_set, convention="CUSTOM", pattern="{name}")
    assert "Expected {level} in the pattern of names, found '{name}'" in message
    assert len(bpy.data.objects) == 2 and not bpy.data.collections.get("Shape_LODs")


def test_names_that_are_taken(previewed):
    make(previewed)
    bpy.context.view_layer.objects.active = previewed
    before = len(bpy.data.objects)
    assert "Expected 'Shape_LOD0' to be free" in refusal(bpy.ops.object.npmesh_lod_set)
    assert len(bpy.data.objects) == before


def test_names_that_are_too_long(previewed):
    assert "of at most 63 bytes" in refusal(bpy.ops.object.npmesh_lod_set, name="x" * 60)


def test_braces_in_names_are_only_braces(previewed):
    make(previewed, name="{0.__class__}")
    assert "{0.__class__}_LOD1" in bpy.data.objects


def test_needs_a_preview():
    assert "Expected a preview" in refusal(bpy.ops.object.npmesh_lod_set)
