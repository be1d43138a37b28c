"""Calls with arguments of another kind: one line that names the right call."""
import numpy as np
import pytest

from npm_blender.core import LodSettings, TriMesh, compress, open_stream
from npm_blender.core.codec import compression, receive
from npm_blender.core.errors import MeshError, SettingsError, StreamError
from tests.core.codec.test_stored_stream import DATA
from tests.meshes.base_meshes import sphere

V, F = sphere(3)


def test_arrays_instead_of_a_mesh_are_told_how_to_make_one():
    with pytest.raises(MeshError, match=r"found an array; call compress\(TriMesh.from_arrays\(V, F\)\)"):
        compress(V, F)
    with pytest.raises(MeshError, match="found a list"):
        compress(V.tolist())


@pytest.mark.parametrize(("settings", "words"), [
    (LodSettings(), r"found a LodSettings; call compress\(mesh, CompressSettings\(lod="),
    ({"base_faces": 400}, r"found a dict; call compress\(mesh, CompressSettings"),
])
def test_settings_that_are_no_compress_settings_are_refused(settings, words):
    with pytest.raises(SettingsError, match=words):
        compress(TriMesh.from_arrays(V, F), settings)


@pytest.mark.parametrize("name", ["mesh.npmesh", compression.__file__])
def test_a_path_instead_of_bytes_is_told_to_be_read_first(name, tmp_path):
    for path in (name, tmp_path / "mesh.npmesh"):
        with pytest.raises(StreamError, match=r"found a path; call open_stream\(Path\(name\).read_bytes\(\)\)"):
            open_stream(path)
    with pytest.raises(StreamError, match="found a NoneType"):
        open_stream(None)


def test_a_level_that_does_not_exist_is_refused_by_its_number():
    opened = receive(DATA["displaced"]).open()
    with pytest.raises(SettingsError, match="level from 0 to 2, found 4"):
        opened.decode(level=4)
    with pytest.raises(SettingsError, match=r"whole number, found 'fine'; call decode\(level="):
        opened.decode(level="fine")
    assert len(opened.decode(level=np.int64(1)).F) == opened.faces_at(1)


def test_a_first_run_without_progress_warns_that_it_compiles(monkeypatch):
    monkeypatch.setattr(compression, "needs_compiling", lambda: True)
    with pytest.warns(UserWarning, match="compiling takes up to a minute"):
        compression._told_of_compiling(None)
    said = []
    compression._told_of_compiling(lambda fraction, message: said.append(message))(0.5, "Decimating")
    assert said == [f"Decimating ({compression.COMPILING})"]
