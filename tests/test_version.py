"""The version stands in one place, npm_blender/version.py; what must repeat it repeats it."""
import ast
import importlib.metadata
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from npm_blender import __version__
from npm_blender.cli import main

ROOT = Path(__file__).parent.parent
HOME = ROOT / "npm_blender" / "version.py"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def newest_heading() -> str:
    """The first heading of a release in CHANGELOG.md."""
    return re.search(r"(?m)^## (.+)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"))[1]


def test_it_is_three_numbers():
    """What Blender's manifest and pip both read in the same way."""
    assert re.fullmatch(r"(0|[1-9]\d*)(\.(0|[1-9]\d*)){2}", __version__)


def test_it_is_a_plain_string_set_once():
    """The build reads it without importing the package."""
    values = [node.value for node in ast.parse(HOME.read_text(encoding="utf-8")).body if isinstance(node, ast.Assign)
              and [target.id for target in node.targets] == ["__version__"]]
    assert [ast.literal_eval(value) for value in values] == [__version__]


def test_the_build_reads_it():
    assert PROJECT["project"]["dynamic"] == ["version"] and "version" not in PROJECT["project"]
    assert ROOT / PROJECT["tool"]["hatch"]["version"]["path"] == HOME


def test_the_manifest_has_it():
    manifest = tomllib.loads((ROOT / "npm_blender" / "blender_manifest.toml").read_text(encoding="utf-8"))
    assert manifest["version"] == __version__


def test_the_newest_release_in_the_changes_is_it():
    """Unreleased, or with its date."""
    assert re.fullmatch(re.escape(__version__) + r" \((unreleased|\d{4}-\d\d-\d\d)\)", newest_heading())


def test_an_installed_package_says_it():
    try:
        installed = importlib.metadata.version("npm-blender")
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("npm-blender is not installed here, it runs from its folder")
    assert installed == __version__


def test_no_other_file_of_the_package_holds_it():
    holders = [path for path in (ROOT / "npm_blender").glob("**/*.py") if f'"{__version__}"' in path.read_text(encoding="utf-8")]
    assert holders == [HOME]


@pytest.mark.parametrize("prog", ["npmesh", "python -m npm_blender", "blender --command npmesh"])
def test_every_command_line_says_it(capfd, prog):
    assert main(["--version"], prog=prog) == 0
    assert capfd.readouterr() == (f"npmesh {__version__}\n", "")


def test_saying_it_loads_nothing_heavy():
    code = "import sys; from npm_blender.cli import main; main(['--version']); print('@@', *sys.modules)"
    said = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert not set(said.rpartition("@@")[2].split()) & {"bpy", "torch", "numba", "numpy"}
