"""What Compress takes: modifiers, shape keys, curves, scales, hidden originals; and that it leaves the object as it is."""
import bpy
import numpy as np
import pytest

from .conftest import add_object, positions, refusal
from .test_batch import QUICK

OURS = ("npmesh", "npmesh_stream", "npmesh_arrays", "npmesh_measured")


def state(obj) -> dict:
    """Everything about an object that compressing must leave alone, as comparable values."""
    mesh = obj.data
    return {
        "positions": positions(obj).tobytes(),
        "faces": [tuple(p.vertices) for p in mesh.polygons],
        "mesh": mesh.name, "users": mesh.users, "attributes": sorted(a.name for a in mesh.attributes),
        "modifiers": [(m.name, m.type, m.show_viewport, m.levels) for m in obj.modifiers],
        "keys": [(k.name, k.value) for k in mesh.shape_keys.key_blocks],
        "groups": [g.name for g in obj.vertex_groups],
        "materials": [slot.material.name for slot in obj.material_slots],
        "transform": [tuple(obj.location), tuple(obj.rotation_euler), tuple(obj.scale), obj.parent],
        "constraints": [c.type for c in obj.constraints],
        "properties": {k: obj[k] for k in obj.keys() if k not in OURS},
        "collections": [c.name for c in obj.users_collection],
    }


def test_the_original_is_untouched():
    obj = add_object(subdivisions=4)
    obj.modifiers.new("Finer", "SUBSURF").levels = 1
    obj.shape_key_add(name="Basis")
    obj.shape_key_add(name="Wide").value = 0.5
    obj.shape_key_add(name="High", from_mix=False)
    obj.vertex_groups.new(name="Arm").add([0, 1], 1.0, "REPLACE")
    obj.data.uv_layers.new(name="UV")
    obj.data.materials.append(bpy.data.materials.new("Clay"))
    obj.location, obj.rotation_euler, obj.scale = (1, 2, 3), (0.3, 0.2, 0.1), (2, 1, -2)
    obj["kept"] = "by the artist"
    obj.constraints.new("LIMIT_LOCATION")
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.collection.objects.link(parent)
    obj.parent = parent
    before = state(obj)
    bpy.ops.object.npmesh_compress(**QUICK)
    assert state(obj) == before and set(obj.keys()) - set(OURS) == {"kept"}
    bpy.ops.object.npmesh_discard()
    assert state(obj) == before and not obj.hide_get()


def test_shape_keys_are_taken_as_they_show():
    obj = add_object(subdivisions=4)
    obj.shape_key_add(name="Basis")
    wide = obj.shape_key_add(name="Wide")
    for point in wide.data:
        point.co.x *= 3
    wide.value = 1
    bpy.ops.object.npmesh_compress(**QUICK)
    shown = bpy.context.active_object
    assert abs(np.ptp(positions(shown)[:, 0]) / np.ptp(positions(obj)[:, 0]) - 3) < 0.3
    assert "Not kept: 1 UV map, 2 shape keys" in obj.npmesh.report


@pytest.mark.parametrize(("add", "options"), [
    ("object.text_add", {}),
    ("object.metaball_add", {"type": "BALL"}),
    ("surface.primitive_nurbs_surface_torus_add", {}),
    ("curve.primitive_bezier_circle_add", {"bevel": 0.2}),
])
def test_curves_text_and_metaballs_are_compressed_as_they_are_drawn(add, options):
    group, _, name = add.partition(".")
    bevel = options.pop("bevel", 0)
    getattr(getattr(bpy.ops, group), name)(**options)
    obj = bpy.context.active_object
    if bevel:
        obj.data.bevel_depth = bevel
    if obj.type == "FONT":
        obj.data.extrude = 0.1
    kind = obj.type
    bpy.ops.object.npmesh_compress(**QUICK)
    shown = bpy.context.active_object
    assert shown.type == "MESH" and shown.npmesh.source == obj and len(shown.data.polygons) >= 4 * 20
    assert obj.type == kind and obj.hide_get()
    bpy.ops.object.npmesh_discard()
    assert bpy.context.active_object == obj and not obj.hide_get()


def test_a_curve_without_faces_says_so():
    bpy.ops.curve.primitive_bezier_curve_add()
    assert "'BézierCurve': Expected a mesh with" in refusal(bpy.ops.object.npmesh_compress)


def test_an_instance_of_a_collection_says_what_to_do():
    group = bpy.data.collections.new("Group")
    group.objects.link(bpy.data.objects.new("Part", bpy.data.meshes.new("Part")))
    instance = bpy.data.objects.new("Instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", group
    bpy.context.collection.objects.link(instance)
    instance.select_set(True)
    assert "make its instances real first" in refusal(bpy.ops.object.npmesh_compress)


def test_several_scales_for_one_object_are_reported():
    obj = add_object(subdivisions=4)
    obj.scale = (1, 1, -3)
    bpy.context.view_layer.update()
    bpy.ops.object.npmesh_compress(**QUICK)
    assert "apply the scale" in obj.npmesh.report and bpy.context.active_object.scale == obj.scale


def test_a_hidden_original_keeps_its_modifiers():
    obj = add_object(subdivisions=4)
    obj.modifiers.new("Finer", "SUBSURF").levels = 1
    bpy.ops.object.npmesh_compress(**QUICK)
    assert obj.hide_get()
    bpy.ops.object.npmesh_compress()
    assert bpy.context.active_object.npmesh.source_faces == 2 * 3 * 1280


def test_an_original_that_is_disabled_is_refused_rather_than_taken_without_its_modifiers():
    obj = add_object(subdivisions=4)
    bpy.ops.object.npmesh_compress(**QUICK)
    obj.hide_viewport = True
    assert "found it disabled in viewports" in refusal(bpy.ops.object.npmesh_compress)
    obj.hide_viewport = False
    group = bpy.data.collections.new("Group")
    bpy.context.scene.collection.children.link(group)
    for collection in obj.users_collection:
        collection.objects.unlink(obj)
    group.objects.link(obj)
    group.hide_viewport = True
    assert "found it disabled in viewports" in refusal(bpy.ops.object.npmesh_compress)


def test_quads_and_triangles_give_the_same_triangles(part):
    bpy.ops.mesh.primitive_uv_sphere_add()
    obj = bpy.context.active_object
    bridge, depsgraph = part("bridge"), bpy.context.evaluated_depsgraph_get()
    mixed = bridge.mesh_of(obj, depsgraph)
    assert bridge.triangle_count(obj, depsgraph) == len(mixed.F)
    obj.modifiers.new("Triangles", "TRIANGULATE").min_vertices = 4
    triangles = bridge.mesh_of(obj, bpy.context.evaluated_depsgraph_get())
    assert np.array_equal(triangles.V, mixed.V) and len(triangles.F) == len(mixed.F)
    assert np.isclose(triangles.face_areas().sum(), mixed.face_areas().sum())


def test_a_mesh_that_does_not_fit_into_memory_is_one_line(part, monkeypatch):
    def too_large(mesh):
        raise MemoryError

    monkeypatch.setattr(part("bridge"), "_triangles", too_large)
    add_object()
    assert "'Shape': Expected a mesh that fits into memory" in refusal(bpy.ops.object.npmesh_compress)


def test_an_override_is_refused():
    import tempfile
    from pathlib import Path

    add_object("Linked")
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder, "library.blend"))
        bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        with bpy.data.libraries.load(path, link=True) as (_, linked):
            linked.objects = ["Linked"]
        obj = linked.objects[0]
        bpy.context.collection.objects.link(obj)
        bpy.context.view_layer.objects.active = obj
        obj.select_set(True)
        assert "linked from a file; make it local first" in refusal(bpy.ops.object.npmesh_compress)
        override = obj.override_create(remap_local_usages=True)
        override.select_set(True)
        bpy.context.view_layer.objects.active = override
        assert "a library override; make it local first" in refusal(bpy.ops.object.npmesh_compress)
