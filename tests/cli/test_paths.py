"""Paths: bad ones are named in one line with exit code 2, and nothing is read, computed or written before."""
import pytest

from npm_blender.cli.files import MESH_SUFFIXES, check_output
from npm_blender.core.errors import FileError
from npm_blender.core.meshio import FORMATS


@pytest.fixture
def folder(tmp_path, sphere_file):
    """A folder with a mesh, a foreign .npmesh, an empty file and a folder."""
    (tmp_path / "mesh.ply").write_bytes(sphere_file.read_bytes())
    (tmp_path / "foreign.npmesh").write_bytes(b"PK\x03\x04 this is some archive, not ours" * 20)
    (tmp_path / "empty.npmesh").write_bytes(b"")
    (tmp_path / "empty.ply").write_bytes(b"")
    (tmp_path / "notes.txt").write_text("hello")
    (tmp_path / "folder.npmesh").mkdir()
    return tmp_path


BAD_PATHS = {
    "input missing": ("compress none.ply out.npmesh", "none.ply"),
    "input is a folder": ("compress folder.npmesh out.npmesh", "folder"),
    "input of unknown kind": ("compress notes.txt out.npmesh", "notes.txt"),
    "input empty": ("compress empty.ply out.npmesh", "empty"),
    "output of wrong suffix": ("compress mesh.ply out.ply", ".npmesh"),
    "output without suffix": ("compress mesh.ply out", "no suffix"),
    "output folder missing": ("compress mesh.ply none/out.npmesh", "none"),
    "output is a folder": ("compress mesh.ply folder.npmesh", "folder"),
    "stream missing": ("info none.npmesh", "none.npmesh"),
    "stream is a folder": ("info folder.npmesh", "folder"),
    "stream empty": ("info empty.npmesh", "empty"),
    "stream missing to decode": ("decompress none.npmesh out.ply", "none.npmesh"),
    "decoded to unknown kind": ("decompress foreign.npmesh out.fbx", ".glb"),
    "decoded to a stream": ("decompress foreign.npmesh out.npmesh", ".glb"),
    "decoded to missing folder": ("decompress foreign.npmesh none/out.ply", "none"),
    "original missing": ("evaluate foreign.npmesh none.ply", "none.ply"),
    "demo of nothing": ("demo none.ply", "none.ply"),
}


@pytest.mark.parametrize("command, named", BAD_PATHS.values(), ids=BAD_PATHS)
def test_bad_path(run, folder, monkeypatch, command, named):
    monkeypatch.chdir(folder)
    before = sorted(folder.iterdir())
    outcome = run(*command.split())
    assert outcome.code == 2
    assert outcome.out == ""
    assert named in outcome.error_line
    assert sorted(folder.iterdir()) == before


@pytest.mark.parametrize("alias", ["same name", "other spelling", "hard link"])
def test_output_is_never_the_input(tmp_path, alias):
    source = tmp_path / "a.npmesh"
    source.write_bytes(b"precious")
    target = source
    if alias == "other spelling":
        (tmp_path / "sub").mkdir()
        target = tmp_path / "sub" / ".." / "a.npmesh"
    elif alias == "hard link":
        target = tmp_path / "b.npmesh"
        target.hardlink_to(source)
    with pytest.raises(FileError, match="other than the input"):
        check_output(target, source, (".npmesh",))


def test_output_may_replace_another_file(tmp_path):
    source, target = tmp_path / "a.ply", tmp_path / "a.NPMESH"
    source.write_bytes(b"a")
    target.write_bytes(b"b")
    assert check_output(target, source, (".npmesh",)) == target


def test_outputs_may_have_the_suffixes_that_can_be_written():
    assert MESH_SUFFIXES == tuple(suffix for suffix, form in FORMATS.items() if form.write)
