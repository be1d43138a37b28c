"""Preview and original: in one place, side by side, and whose they must be to be changed."""
import bpy
import numpy as np
import pytest
from mathutils import Matrix

from npm_blender.core.codec import open_stream

from .conftest import add_object, positions, refusal


def extent(obj):
    """Least and greatest x in the world."""
    bpy.context.view_layer.update()
    V = positions(obj) @ np.array(obj.matrix_world.to_3x3()).T + np.array(obj.matrix_world.translation)
    return V[:, 0].min(), V[:, 0].max()


def close(a, b):
    return np.allclose(np.array(a), np.array(b), atol=1e-5)


@pytest.mark.parametrize("parent", [False, True])
def test_beside_and_back(part, received, parent):
    preview, source = part("preview"), add_object()
    source.location, source.rotation_euler, source.scale = (1, 2, 3), (0.3, 0.2, 0.9), (2, 1, 0.5)
    if parent:
        above = bpy.data.objects.new("Parent", None)
        bpy.context.collection.objects.link(above)
        above.location, above.rotation_euler, above.scale = (3, 0, 1), (0, 0.7, 0.1), (1.5, 1.5, 1.5)
        source.parent = above
    bpy.context.view_layer.update()
    shown = preview.make(bpy.context, received, "Shape Preview", source)
    bpy.context.view_layer.update()
    rotation = tuple(shown.rotation_euler)
    shown.npmesh.beside = True
    assert not source.hide_get() and not shown.hide_get() and tuple(shown.rotation_euler) == rotation
    assert extent(shown)[0] > extent(source)[1]
    assert close(shown.matrix_world.to_3x3(), source.matrix_world.to_3x3())
    assert close(shown.matrix_world.translation.yz, source.matrix_world.translation.yz)
    shown.npmesh.beside = False
    bpy.context.view_layer.update()
    assert source.hide_get() and close(shown.matrix_world, source.matrix_world)


def test_show_original_ends_beside(previewed):
    source = previewed.npmesh.source
    previewed.npmesh.beside = True
    previewed.npmesh.show_original = True
    assert not previewed.npmesh.beside and not source.hide_get() and previewed.hide_get()
    bpy.context.view_layer.update()
    assert close(previewed.matrix_world, source.matrix_world)


def test_beside_without_an_original_moves_nothing(opened):
    opened.npmesh.beside = True
    assert close(opened.matrix_world, Matrix())


def test_discard_while_beside_leaves_the_original_where_it_was(previewed):
    source = previewed.npmesh.source
    previewed.npmesh.beside = True
    bpy.ops.object.npmesh_discard()
    assert not source.hide_get() and list(bpy.data.objects) == [source]


OPERATORS = ("npmesh_apply", "npmesh_discard", "npmesh_lod_set", "npmesh_link", "npmesh_pack", "npmesh_reload")


@pytest.fixture
def library(opened, tmp_path):
    """A .blend that holds a preview."""
    path = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, check_existing=False)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return path


def bring(library, link):
    with bpy.data.libraries.load(library, link=link) as (_, found):
        found.objects = ["shape"]
    bpy.context.collection.objects.link(found.objects[0])
    bpy.context.view_layer.objects.active = found.objects[0]
    return found.objects[0]


def test_an_override_is_left_alone_and_says_so(part, library):
    obj = bring(library, link=True).override_create(remap_local_usages=True)
    if obj.name not in bpy.context.view_layer.objects:
        bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    before = positions(obj)
    obj.npmesh.features = 1
    obj.npmesh.show_deviation = True
    assert np.array_equal(positions(obj), before)
    assert "a library override; make it local first" in part("preview").foreign(obj)
    for name in OPERATORS:
        arguments = {"filepath": "x.npmesh"} if name == "npmesh_link" else {}
        assert "make it local first" in refusal(getattr(bpy.ops.object, name), **arguments)
    assert "make it local first" in refusal(bpy.ops.export_scene.npmesh_gltf, filepath="x.glb")


def test_a_linked_preview_is_left_alone(library):
    obj = bring(library, link=True)
    before = positions(obj)
    obj.npmesh.features = 1
    assert np.array_equal(positions(obj), before)
    assert "linked from a file; make it local first" in refusal(bpy.ops.object.npmesh_lod_set)


def test_an_object_made_local_gets_meshes_of_its_own(part, library):
    obj = bring(library, link=True)
    obj.make_local()
    obj = bpy.data.objects["shape"]
    assert obj.library is None and obj.data.library is not None
    obj.npmesh.features = 5
    assert obj.data.library is None
    V = open_stream(obj["npmesh_stream"]).decode_positions(5, 2)
    assert np.array_equal(positions(obj), V.astype(np.float32))


def test_an_appended_preview_lives(part, library):
    obj = bring(library, link=False)
    obj.npmesh.level, obj.npmesh.features = "1", 4
    V = open_stream(obj["npmesh_stream"]).decode_positions(4, 1)
    assert np.array_equal(positions(obj), V.astype(np.float32))
