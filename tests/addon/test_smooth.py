"""Shading of the decoded levels is that of the original, and their material the one of most of its faces."""
import math

import bpy
import numpy as np
import pytest

from .conftest import add_object


def dihedral(mesh):
    """Angle between the faces of every edge, radians (all edges have two)."""
    normals = {}
    for polygon in mesh.polygons:
        for key in polygon.edge_keys:
            normals.setdefault(key, []).append(np.array(polygon.normal))
    return np.array([math.acos(np.clip(np.dot(*normals[edge.key]), -1, 1)) for edge in mesh.edges])


def sharp(mesh):
    values = np.zeros(len(mesh.edges), dtype=bool)
    if "sharp_edge" in mesh.attributes:
        mesh.attributes["sharp_edge"].data.foreach_get("value", values)
    return values


def flat(mesh):
    values = np.zeros(len(mesh.polygons), dtype=bool)
    if "sharp_face" in mesh.attributes:
        mesh.attributes["sharp_face"].data.foreach_get("value", values)
    return values


@pytest.fixture
def preview_of(part, received):
    def make(prepare):
        source = add_object()
        prepare(source.data)
        return part("preview").make(bpy.context, received, "Shape Preview", source)

    return make


def test_smooth(preview_of):
    shown = preview_of(lambda mesh: mesh.shade_smooth())
    assert shown.npmesh.shading == "SMOOTH" and not flat(shown.data).any() and not sharp(shown.data).any()


def test_flat(preview_of):
    shown = preview_of(lambda mesh: mesh.shade_flat())
    for level in ("0", "1", "2"):
        shown.npmesh.level = level
        assert shown.npmesh.shading == "FLAT" and flat(shown.data).all()


def by_angle(degrees):
    def prepare(mesh):
        mesh.shade_smooth()
        mesh.set_sharp_from_angle(angle=math.radians(degrees))

    return prepare


def test_the_angle_is_found_from_the_marks_and_kept_at_every_stop(preview_of):
    shown = preview_of(by_angle(12))
    state = shown.npmesh
    assert state.shading == "ANGLE" and state.smooth_angle == pytest.approx(math.radians(12), abs=math.radians(0.5))
    for level, features in (("2", state.total_features), ("2", 0), ("1", 0), ("0", 0), ("2", 25)):
        state.level, state.features = level, features
        angle, marked = dihedral(shown.data), sharp(shown.data)
        clear = np.abs(angle - state.smooth_angle) > 1e-3
        assert np.array_equal(marked[clear], (angle > state.smooth_angle)[clear])
    assert marked.any() and not marked.all()


def test_marks_set_by_hand_are_not_carried_over(preview_of):
    def some(mesh):
        mesh.shade_smooth()
        values = np.zeros(len(mesh.edges), dtype=bool)
        values[::7] = True
        mesh.attributes.new("sharp_edge", "BOOLEAN", "EDGE").data.foreach_set("value", values)

    shown = preview_of(some)
    assert shown.npmesh.shading == "SMOOTH" and not sharp(shown.data).any()


def smooth_by_angle_group():
    """A group of nodes as Blender's asset Smooth by Angle has it, for the names by which it is found."""
    group = bpy.data.node_groups.new("Smooth by Angle", "GeometryNodeTree")
    group.interface.new_socket("Mesh", in_out="INPUT", socket_type="NodeSocketGeometry")
    group.interface.new_socket("Mesh", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    group.interface.new_socket("Angle", in_out="INPUT", socket_type="NodeSocketFloat").default_value = 0.25
    first, last = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    group.links.new(first.outputs[0], last.inputs[0])
    return group


def test_the_modifier_tells_the_angle(part, received):
    source = add_object()
    source.data.shade_smooth()
    source.modifiers.new("Smooth by Angle", "NODES").node_group = smooth_by_angle_group()
    shown = part("preview").make(bpy.context, received, "Shape Preview", source)
    assert shown.npmesh.shading == "ANGLE" and shown.npmesh.smooth_angle == pytest.approx(0.25)


def test_an_opened_file_is_smooth(opened):
    assert opened.npmesh.shading == "SMOOTH" and not flat(opened.data).any()


@pytest.mark.parametrize(("faces", "name"), [(0.2, "Clay"), (0.8, "Gold")])
def test_the_material_of_most_faces(part, received, faces, name):
    source = add_object()
    for material in ("Clay", "Gold"):
        source.data.materials.append(bpy.data.materials.new(material))
    count = len(source.data.polygons)
    source.data.polygons.foreach_set("material_index", (np.arange(count) < faces * count).astype(np.int32))
    shown = part("preview").make(bpy.context, received, "Shape Preview", source)
    for level in ("2", "0"):
        shown.npmesh.level = level
        assert [m.name for m in shown.data.materials] == [name]


def test_an_object_without_material(part, received):
    shown = part("preview").make(bpy.context, received, "Shape Preview", add_object())
    assert not shown.data.materials
