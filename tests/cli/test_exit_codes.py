"""Every way that a command can end early: its exit code, its one line, and the output file as it was."""
import sys
import types

import pytest

from npm_blender.core import errors

ENDS = {
    "bad mesh": (errors.MeshError("Expected a surface, found none; add faces"), 2, "Expected a surface"),
    "bad stream": (errors.StreamError("Expected an .npmesh stream, found none; check it"), 2, "Expected an .npmesh"),
    "bad setting": (errors.SettingsError("Expected levels, found none; set them"), 2, "Expected levels"),
    "missing weights": (errors.WeightsError("Expected the weights, found none; reinstall"), 2, "Expected the weights"),
    "missing package": (errors.DependencyError("Expected numba, found none; install it"), 2, "Expected numba"),
    "message of two lines": (errors.MeshError("Expected this,\nfound that"), 2, "Expected this, found that"),
    "cancelled": (errors.Cancelled("by the user"), 1, "cancelled"),
    "interrupted": (KeyboardInterrupt(), 1, "cancelled"),
    "disk full": (OSError(28, "No space left on device", "out.npmesh"), 1, "No space left on device: out.npmesh"),
    "out of memory": (MemoryError(), 1, "out of memory"),
    "package not installed": (ModuleNotFoundError("No module named 'numba'", name="numba"), 1, "numba"),
}


@pytest.fixture
def ending(monkeypatch):
    """ending(error): make the codec end with `error`."""
    def ending(error: BaseException) -> None:
        def fail(*_, **__):
            raise error

        codec = types.ModuleType("npm_blender.core.codec")
        codec.compress = codec.open_stream = fail
        monkeypatch.setitem(sys.modules, "npm_blender.core.codec", codec)

    return ending


@pytest.mark.parametrize("error, code, words", ENDS.values(), ids=ENDS)
def test_ends_with_one_line_and_leaves_the_output_alone(run, ending, sphere_file, tmp_path, error, code, words):
    target = tmp_path / "out.npmesh"
    target.write_bytes(b"from before")
    ending(error)
    outcome = run("compress", sphere_file, target)
    assert outcome.code == code
    assert words in outcome.error_line
    assert outcome.out == ""
    assert [p.name for p in tmp_path.iterdir()] == ["out.npmesh"]
    assert target.read_bytes() == b"from before"


def test_our_own_bug_keeps_its_traceback(run, ending, sphere_file, tmp_path):
    ending(ZeroDivisionError("by zero"))
    outcome = run("compress", sphere_file, tmp_path / "out.npmesh")
    assert outcome.code == 1
    assert "Traceback" in outcome.err and "ZeroDivisionError" in outcome.err
    assert outcome.err.splitlines()[-1].startswith("npmesh: error: this is a bug")


def test_write_that_fails_half_way_leaves_no_part(run, monkeypatch, sphere_file, tmp_path):
    codec = types.ModuleType("npm_blender.core.codec")
    codec.compress = lambda *_: types.SimpleNamespace(data=b"new", report=None)
    monkeypatch.setitem(sys.modules, "npm_blender.core.codec", codec)

    def no_space(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", no_space)
    (tmp_path / "out.npmesh").write_bytes(b"from before")
    outcome = run("compress", sphere_file, tmp_path / "out.npmesh")
    assert outcome.code != 0 and "No space left on device" in outcome.error_line
    assert [p.name for p in tmp_path.iterdir()] == ["out.npmesh"]
    assert (tmp_path / "out.npmesh").read_bytes() == b"from before"
