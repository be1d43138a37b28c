"""What pip is told about the package: true of the package, and of the versions that we test with."""
import ast
import importlib
import re
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from npm_blender.runtime import packages

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
PROJECT = tomllib.loads(TEXT)["project"]
HATCH = tomllib.loads(TEXT)["tool"]["hatch"]
MANIFEST = tomllib.loads((ROOT / "npm_blender" / "blender_manifest.toml").read_text(encoding="utf-8"))
EXTRAS = {name: [Requirement(line) for line in lines] for name, lines in PROJECT["optional-dependencies"].items()}
NEEDED = [Requirement(line) for line in PROJECT["dependencies"]]
OF_BLENDER = {"bpy", "bpy_extras", "bmesh", "mathutils", "gpu", "gpu_extras", "blf", "addon_utils", "bl_ui"}


def pins(name: str) -> dict[str, str]:
    """Versions by name in requirements/`name`.txt, without the files that it includes."""
    text = (ROOT / "requirements" / f"{name}.txt").read_text(encoding="utf-8")
    return dict(re.findall(r"(?m)^([\w.-]+)==([\w.]+)", text))


def imported() -> set[str]:
    """Top names of what npm_blender imports and Python does not bring, wherever the import stands in a file."""
    names = set()
    for path in (ROOT / "npm_blender").glob("**/*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                names.add(node.module.partition(".")[0])
    return names - set(sys.stdlib_module_names)


def test_everything_to_run_is_a_dependency():
    assert {r.name for r in [*NEEDED, *EXTRAS["tetwild"]]} == set(pins("run"))


@pytest.mark.parametrize("requirement", [*NEEDED, *sum(EXTRAS.values(), [])], ids=lambda r: r.name)
def test_ranges_admit_the_versions_that_we_test_with(requirement):
    tested = {**pins("run"), "torch": pins("train")["torch"]}[requirement.name]
    assert requirement.specifier.contains(tested)
    assert any(part.operator == ">=" for part in requirement.specifier)
    assert not any(part.operator == "==" for part in requirement.specifier)  # a library leaves room for others


@pytest.mark.parametrize("line", [*PROJECT["dependencies"], *sum(PROJECT["optional-dependencies"].values(), []),
                                  *tomllib.loads(TEXT)["build-system"]["requires"]])
def test_every_requirement_has_its_reason_beside_it(line):
    assert re.search(rf'"{re.escape(line)}"[\],]*\s+# \S', TEXT)


def test_every_import_is_declared():
    declared = {r.name for r in [*NEEDED, *sum(EXTRAS.values(), [])]}
    assert imported() - OF_BLENDER <= declared


def test_what_preferences_list_is_declared():
    assert {p.name for p in packages.PACKAGES} <= {r.name for r in [*NEEDED, *sum(EXTRAS.values(), [])]}


def test_the_advice_on_tetwild_is_in_its_range():
    text = (ROOT / "npm_blender" / "core" / "cleaning" / "tetwild.py").read_text(encoding="utf-8")
    assert EXTRAS["tetwild"][0].specifier.contains(re.search(r"pip install pytetwild==([\d.]+)", text)[1])


def test_python_is_what_the_linter_and_this_interpreter_take():
    oldest = tomllib.loads(TEXT)["tool"]["ruff"]["target-version"]
    assert PROJECT["requires-python"] == f">=3.{oldest.removeprefix('py3')}"
    assert SpecifierSet(PROJECT["requires-python"]).contains(".".join(map(str, sys.version_info[:3])))


def test_licence_and_description_are_the_manifests():
    assert MANIFEST["license"] == [f"SPDX:{PROJECT['license']}"]
    assert MANIFEST["tagline"] == PROJECT["description"]
    assert not any(c.startswith("License ::") for c in PROJECT["classifiers"])  # the expression takes their place
    assert all((ROOT / name).is_file() for name in [*PROJECT["license-files"], PROJECT["readme"]])


def test_the_wheel_holds_the_package_alone_and_its_data():
    assert HATCH["build"]["targets"]["wheel"]["packages"] == ["npm_blender"]
    assert all((ROOT / name).exists() for name in HATCH["build"]["targets"]["sdist"]["only-include"])
    ignored = (ROOT / ".gitignore").read_text(encoding="utf-8").split()  # the build leaves out what git ignores
    for data in ("weights/npm1.npz", "blender_manifest.toml"):
        assert (ROOT / "npm_blender" / data).is_file()
        assert not any(part in line for line in ignored for part in (Path(data).suffix, "weights"))
    assert {"__pycache__/", "*.egg-info/", "/dist/", "/build/"} <= set(ignored)


@pytest.mark.parametrize("arguments, code", [(["--version"], 0), (["info", "missing.npmesh"], 2), ([], 2)])
def test_the_command_keeps_the_exit_code(monkeypatch, capfd, tmp_path, arguments, code):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["npmesh", *arguments])
    (name, target), = PROJECT["scripts"].items()
    module, _, function = target.partition(":")
    assert getattr(importlib.import_module(module), function)() == code
    out, err = capfd.readouterr()
    assert (out if code == 0 else err).startswith(name)
