"""The decoded level as glTF, through Blender's exporter."""
import json
import struct

import addon_utils
import bpy
import numpy as np
import pytest

from .conftest import refusal


@pytest.fixture
def exporter():
    """Blender's glTF add-on, enabled; a factory start has it."""
    if "gltf" not in dir(bpy.ops.export_scene):
        addon_utils.enable("io_scene_gltf2")


def contents(path):
    data = path.read_bytes()
    length, = struct.unpack_from("<I", data, 12)
    return json.loads(data[20:20 + length])


def test_only_the_shown_level_is_written(exporter, previewed, tmp_path):
    previewed.npmesh.level, previewed.npmesh.features = "1", 20
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.active_object
    bpy.context.view_layer.objects.active = previewed
    path = tmp_path / "level.glb"
    assert bpy.ops.export_scene.npmesh_gltf(filepath=str(path)) == {"FINISHED"}
    said = contents(path)
    assert [node["name"] for node in said["nodes"]] == ["Shape Preview"] and "extras" not in said["nodes"][0]
    [primitive] = said["meshes"][0]["primitives"]
    assert said["accessors"][primitive["indices"]]["count"] == 3 * 80 * 4
    assert "COLOR_0" not in primitive["attributes"]
    assert list(bpy.context.selected_objects) == [cube]


def test_the_deviation_is_not_exported_and_comes_back(exporter, previewed, tmp_path):
    previewed.npmesh.show_deviation = True
    bpy.ops.export_scene.npmesh_gltf(filepath=str(tmp_path / "a.glb"))
    [primitive] = contents(tmp_path / "a.glb")["meshes"][0]["primitives"]
    assert not [name for name in primitive["attributes"] if "COLOR" in name.upper() or "DEV" in name.upper()]
    assert previewed.npmesh.show_deviation and "Deviation" in previewed.data.color_attributes


def test_a_hidden_preview_is_exported_too(exporter, previewed, tmp_path):
    previewed.npmesh.show_original = True
    bpy.ops.export_scene.npmesh_gltf(filepath=str(tmp_path / "a.gltf"))
    assert (tmp_path / "a.gltf").exists() and previewed.hide_get()
    said = json.loads((tmp_path / "a.gltf").read_text())
    low = np.array(said["accessors"][said["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]["min"])
    assert np.all(low < -0.5)


def test_the_exporter_switched_off(exporter, previewed, tmp_path):
    addon_utils.disable("io_scene_gltf2")
    try:
        message = refusal(bpy.ops.export_scene.npmesh_gltf, filepath=str(tmp_path / "a.glb"))
        assert "Expected Blender's glTF exporter, found it switched off; enable glTF 2.0 format" in message
    finally:
        addon_utils.enable("io_scene_gltf2")


def test_a_wrong_suffix_and_a_missing_folder(exporter, previewed, tmp_path):
    message = refusal(bpy.ops.export_scene.npmesh_gltf, filepath=str(tmp_path / "a.obj"), check_existing=False)
    assert "ends in .glb or .gltf" in message
    message = refusal(bpy.ops.export_scene.npmesh_gltf, filepath=str(tmp_path / "no" / "a.glb"))
    assert "Expected an existing folder" in message
