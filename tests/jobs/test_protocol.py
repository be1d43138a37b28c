"""What one process of a job writes, the other reads."""
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from npm_blender.core import errors
from npm_blender.core.codec.stored_stream import StoredStream
from npm_blender.core.mesh.triangle_mesh import TriMesh
from npm_blender.core.settings import CompressSettings, LodSettings
from npm_blender.jobs import process, protocol


def test_a_mesh_and_its_settings_arrive_and_take_no_more_space(tmp_path):
    mesh = TriMesh.from_arrays(np.eye(3, dtype=np.float32), np.array([[0, 1, 2]]))
    settings = CompressSettings(lod=LodSettings(base_faces=123, clean="off"), model="paper", budget=900)
    protocol.write_mesh(tmp_path, 3, mesh, settings)
    arrived, its = protocol.take_mesh(tmp_path, 3)
    assert np.array_equal(arrived.V, mesh.V) and np.array_equal(arrived.F, mesh.F) and its == settings
    assert not list(tmp_path.glob("*.npz"))


def test_the_names_of_files_arrive_whole_and_a_job_without_has_none(tmp_path, monkeypatch):
    assert protocol.read_paths(tmp_path) is None
    monkeypatch.chdir(tmp_path)
    protocol.write_paths(tmp_path, [Path("ä.npmesh"), Path("/a/b.npmesh")])
    assert protocol.read_paths(tmp_path) == [tmp_path / "ä.npmesh", Path("/a/b.npmesh")]


def test_a_check_is_asked_for(tmp_path):
    assert not protocol.is_check(tmp_path)
    protocol.ask_for_check(tmp_path)
    assert protocol.is_check(tmp_path)


def test_a_stream_arrives_with_what_was_read_and_measured(tmp_path):
    received = StoredStream(b"\0stream", b"\0arrays", "measured")
    protocol.write_received(tmp_path, 1, received)
    assert protocol.read_received(tmp_path, 1) == received


@pytest.mark.parametrize("kind", [errors.MeshError, errors.StreamError, errors.DependencyError])
def test_an_error_keeps_its_class_and_its_words(kind):
    said = protocol.fields_of(protocol.line_of(**protocol.described(kind("Expected\none"))))
    assert type(protocol.error_in(said)) is kind and str(protocol.error_in(said)) == "Expected\none"


def test_what_is_said_is_one_line():
    line = protocol.line_of(fraction=0.5, message="a\nb")
    assert line.endswith("\n") and line.count("\n") == 1 and json.loads(line) == {"fraction": 0.5, "message": "a\nb"}


def test_starting_jobs_loads_nothing_heavy():
    code = "import sys, npm_blender.jobs; print({'bpy', 'numpy', 'numba'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], cwd=process.PACKAGE_FOLDER.parent, capture_output=True, text=True)
    assert done.stdout == "set()\n", done.stderr


def test_the_worker_runs_under_the_name_that_the_package_has_here(tmp_path):
    *_, bootstrap, name, folder, job = process.command(tmp_path)
    assert (name, Path(folder).name, job) == ("npm_blender", "npm_blender", str(tmp_path))
    compile(bootstrap, "bootstrap", "exec")
