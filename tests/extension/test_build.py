"""The zips: Blender's own tool builds and accepts them, and they hold what they should and nothing else.

The wheels are stand-ins with the locked names, so that nothing is downloaded; Blender looks at the names only.
"""
import importlib.util
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from extension import blender, contents, staging, wheels
from extension.build import build
from extension.lock import PLATFORMS, PYTHONS, TEST_PYTHONS, Package, Wheel, chosen, read_lock

PACKAGES = read_lock()
needs_tool = pytest.mark.skipif(blender.program() is None, reason="needs the bpy module, which brings Blender's tool")


def stand_ins(folder: Path, platforms=PLATFORMS, pythons=PYTHONS) -> list[Path]:
    """Files with the names of the wheels that zips need."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / wheel.filename for wheel in chosen(PACKAGES, platforms, pythons)]
    for path in paths:
        path.write_bytes(b"a wheel")
    return paths


@pytest.fixture(scope="module")
def zips(tmp_path_factory):
    """The zips for official Blenders, by platform, from a copy of the package with litter in it."""
    package = tmp_path_factory.mktemp("source") / "npm_blender"
    shutil.copytree(staging.PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("core/__pycache__/a.cpython-311.pyc", "core/b.nbi", "core/b.nbc", ".hidden/c.py", "cli/.DS_Store"):
        (package / name).parent.mkdir(exist_ok=True)
        (package / name).write_text("litter")
    out = staging.ROOT / "build" / "tests" / "dist"
    files = stand_ins(tmp_path_factory.mktemp("wheels"))
    tool = [sys.executable, str(blender.program())]
    yield dict(zip(PLATFORMS, build(PACKAGES, PLATFORMS, PYTHONS, files, out, tool, package), strict=True))
    shutil.rmtree(out)
    shutil.rmtree(staging.ROOT / "build" / "staged" / out.name)


@needs_tool
@pytest.mark.parametrize("platform", PLATFORMS)
def test_a_zip_holds_what_it_should(zips, platform):
    assert contents.problems(zips[platform], PACKAGES, platform, PYTHONS) == []
    with zipfile.ZipFile(zips[platform]) as archive:
        names = set(archive.namelist())
        text = archive.read("core/codec/compression.py")
    source = {str(p.relative_to(staging.PACKAGE)) for p in staging.PACKAGE.rglob("*.py")}
    assert source <= names and text == (staging.PACKAGE / "core" / "codec" / "compression.py").read_bytes()
    assert {name for name in names if "." in name and not name.endswith((".py", ".whl"))} == {
        "blender_manifest.toml", "weights/npm1.npz"}


@needs_tool
@pytest.mark.parametrize("platform", PLATFORMS)
def test_blender_derives_the_python_versions_that_its_releases_have(zips, platform):
    with zipfile.ZipFile(zips[platform]) as archive:
        names = [name for name in archive.namelist() if name.endswith(".whl")]
    assert blenders_tool().python_versions_from_wheels(names) == {(3, 11), (3, 13)}


@needs_tool
def test_a_test_build_is_for_debians_pythons(tmp_path):
    names = [path.name for path in stand_ins(tmp_path, ("linux-x64",), TEST_PYTHONS)]
    assert blenders_tool().python_versions_from_wheels(names) == {(3, 13), (3, 14)}


def blenders_tool():
    """Blender's extension tool as a module."""
    spec = importlib.util.spec_from_file_location("blender_ext", blender.program())
    module = importlib.util.module_from_spec(spec)
    sys.modules["blender_ext"] = module  # its dataclasses look for it
    spec.loader.exec_module(module)
    return module


SETS = [
    (["a-1-cp311-cp311-win_amd64.whl", "b-1-cp312-abi3-win_amd64.whl"], {(3, 11)}),  # the trap: refused on 3.13
    (["a-1-cp311-cp311-win_amd64.whl", "b-1-cp312-abi3-win_amd64.whl", "c-1-cp313-cp313-win_amd64.whl"],
     {(3, 11), (3, 13)}),
    (["a-1-py3-none-any.whl"], {(3,)}),
    (["a-1-py2.py3-none-any.whl"], {(3,)}),
    (["a-1-py3-none-any.whl", "b-1-cp313-cp313-win_amd64.whl"], {(3, 13)}),
    (["b-1-cp312-abi3-win_amd64.whl"], {(3,)}),
    (["a-1-1-cp311.cp312-none-any.whl"], {(3, 11), (3, 12)}),
]


@pytest.mark.parametrize("names, versions", SETS)
def test_our_statement_of_blenders_rule(names, versions):
    assert contents.python_versions(names) == versions


@needs_tool
@pytest.mark.parametrize("names, versions", SETS)
def test_blenders_rule_is_as_we_state_it(names, versions):
    assert blenders_tool().python_versions_from_wheels(names) == versions


def altered(path: Path, target: Path, leave_out: str = "", add: str = "") -> Path:
    """A zip without the files whose names hold `leave_out`, and with one more."""
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(target, "w") as out:
        for name in source.namelist():
            if not leave_out or leave_out not in name:
                out.writestr(name, source.read(name))
        if add:
            out.writestr(add, "more")
    return target


@needs_tool
@pytest.mark.parametrize("leave_out, add, found", [
    ("numba-0.68.1-cp313", "", "is missing for Python 3.13"),
    ("LICENSE", "", "LICENSE is missing"),
    ("", "wheels/numpy-2.3.0-cp313-cp313-manylinux_2_28_x86_64.whl", "another's to bring"),
    ("", "wheels/a-1-cp313-cp313-win_amd64.whl", "for another platform"),
    ("", "wheels/a-1-cp312-cp312-manylinux_2_28_x86_64.whl", "Blender would take it for Python"),
    ("", "core/__pycache__/a.pyc", "no place in it"),
    ("", "tests/test_a.py", "no place in it"),
    ("", "weights/model.pt", "no place in it"),
    ("", "weights/notes.txt", "no weights file"),
    ("", "core/a.nbi", "no place in it"),
])
def test_what_is_wrong_with_a_zip_is_found(zips, tmp_path, leave_out, add, found):
    path = altered(zips["linux-x64"], tmp_path / "altered.zip", leave_out, add)
    assert any(found in problem for problem in contents.problems(path, PACKAGES, "linux-x64", PYTHONS))


@needs_tool
def test_blender_refuses_a_manifest_that_breaks_its_rules(tmp_path):
    folder = staging.ROOT / "build" / "tests" / "bad"
    shutil.rmtree(folder, ignore_errors=True)
    staging.stage(folder, ("linux-x64",), [])
    manifest = folder / staging.MANIFEST
    manifest.write_text(manifest.read_text().replace('tags = ["Import-Export"', 'tags = ["No Such Tag"'))
    try:
        with pytest.raises(blender.ToolError, match="No Such Tag"):
            blender.run([sys.executable, str(blender.program())], "validate", str(folder))
    finally:
        shutil.rmtree(folder)


def test_the_manifest_takes_platforms_and_wheels_before_its_tables():
    text = 'id = "a"\n\n[permissions]\nfiles = "why"\n'
    out = staging.manifest_with(text, ("linux-x64",), ["a-1-py3-none-any.whl"])
    assert out.index("wheels") < out.index("[permissions]") and out.endswith('files = "why"\n')
    assert "./wheels/a-1-py3-none-any.whl" in out


def test_a_wheel_with_other_bytes_is_refused(tmp_path):
    wheel = Wheel("a-1-py3-none-any.whl", "0" * 64)
    (tmp_path / wheel.filename).write_bytes(b"not the locked ones")
    package = Package("a", "1", "why", (), (wheel,))
    with pytest.raises(wheels.FetchError, match="Expected the locked content"):
        wheels.fetch((package,), ("linux-x64",), ("3.11",), tmp_path)


def test_pip_is_told_the_hash_and_its_word_is_passed_on(tmp_path, monkeypatch):
    told = {}

    def refuse(command, **_):
        told["requirement"] = Path(command[-1]).read_text()
        told["command"] = command
        return subprocess.CompletedProcess(command, 1, "", "WARNING: x\nERROR: no such version")

    monkeypatch.setattr(wheels.subprocess, "run", refuse)
    package = Package("a", "1", "why", (), (Wheel("a-1-cp313-cp313-win_amd64.whl", "1" * 64),))
    with pytest.raises(wheels.FetchError, match="ERROR: no such version"):
        wheels.fetch((package,), ("windows-x64",), ("3.13",), tmp_path)
    assert told["requirement"].split() == ["a==1", f"--hash=sha256:{'1' * 64}"]
    assert {"--only-binary=:all:", "win_amd64", "3.13", "--no-deps"} <= set(told["command"])


def test_without_any_blender_one_line_says_what_to_do(monkeypatch):
    monkeypatch.delenv("BLENDER", raising=False)
    monkeypatch.setattr(blender.shutil, "which", lambda name: None)
    monkeypatch.setattr(blender, "program", lambda: None)
    with pytest.raises(blender.ToolError, match="Expected Blender or its Python module"):
        blender.command()
    with pytest.raises(blender.ToolError, match="found none called no-such-blender"):
        blender.command("no-such-blender run")


def test_checking_the_installation_without_a_blender_is_reported_as_not_run(monkeypatch, capsys):
    from extension import check_install

    monkeypatch.delenv("BLENDER", raising=False)
    monkeypatch.setattr(check_install.shutil, "which", lambda name: None)
    assert check_install.main() == 0
    assert capsys.readouterr().out.startswith("not run:")
