"""Which packages are there, found without loading them; torch in every kind of folder that a user may choose."""
import subprocess
import sys
from pathlib import Path

import pytest

from npm_blender.runtime import packages
from npm_blender.runtime.packages import TORCH, VERSION

TAG = VERSION.replace(".", "")


def torch_in(folder: Path, version: str = "2.9.1+cpu", library: str = "") -> Path:
    """Make a folder that holds what torch's wheel does, as far as it is looked at."""
    (folder / "torch").mkdir(parents=True)
    (folder / "torch" / "version.py").write_text(f"from typing import Optional\n__version__ = '{version}'\ncuda = None\n")
    if library:
        (folder / "torch" / library).touch()
    return folder


@pytest.mark.parametrize("inside", ["", "site-packages", f"lib/python{VERSION}/site-packages", "Lib/site-packages"])
def test_torch_is_found_in_a_folder_or_an_environment(tmp_path, inside):
    where = torch_in(tmp_path / "chosen" / inside)
    status = packages.torch_in(str(tmp_path / "chosen"))
    assert (status.version, status.problem, Path(status.path)) == ("2.9.1+cpu", "", where)


def test_torch_is_found_by_a_python_program_and_by_its_own_folder(tmp_path):
    where = torch_in(tmp_path / "venv" / "lib" / f"python{VERSION}" / "site-packages")
    program = tmp_path / "venv" / "bin" / "python"
    program.parent.mkdir()
    program.touch()
    for chosen in (program, where / "torch"):
        assert Path(packages.torch_in(str(chosen)).path) == where


@pytest.mark.parametrize("library, fits", [
    (f"_C.cpython-{TAG}-x86_64-linux-gnu.so", True), (f"_C.cp{TAG}-win_amd64.pyd", True), ("_C.abi3.so", True), ("", True),
    ("_C.cpython-39-x86_64-linux-gnu.so", False), ("_C.cp39-win_amd64.pyd", False)])
def test_torch_for_another_python_is_said_to_be(tmp_path, library, fits):
    status = packages.torch_in(str(torch_in(tmp_path / "chosen", library=library)))
    assert status.problem == ("" if fits else f"made for Python 3.9, not for Python {VERSION}")


def test_an_environment_of_another_python(tmp_path):
    torch_in(tmp_path / "lib" / "python3.9" / "site-packages")
    assert "holds it for python3.9" in packages.torch_in(str(tmp_path)).problem


def test_a_folder_without_torch(tmp_path):
    assert packages.torch_in(str(tmp_path)).problem == f"not in {tmp_path}"
    assert packages.torch_in(str(tmp_path / "none")).problem == f"not in {tmp_path / 'none'}"


def test_looking_loads_nothing():
    code = ("import sys; from npm_blender.runtime import packages; found = packages.found(); "
            "print([s.package.name for s in found if not s.problem], {'numba', 'torch', 'numpy'} & set(sys.modules))")
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "'numba'" in said and said.strip().endswith("set()")


def test_a_missing_package_has_a_problem_and_a_remedy(monkeypatch):
    find = packages.importlib.util.find_spec
    monkeypatch.setattr(packages.importlib.util, "find_spec", lambda name: None if name == "numba" else find(name))
    status = {s.package.name: s for s in packages.found()}
    assert status["numba"].problem == "not found" and status["numba"].package.remedy and not status["numpy"].problem


def test_a_chosen_folder_counts_where_python_has_no_torch(tmp_path, monkeypatch):
    find = packages.importlib.util.find_spec
    monkeypatch.setattr(packages.importlib.util, "find_spec", lambda name: None if name == "torch" else find(name))
    assert packages.found()[-1].problem == "not found"
    assert packages.found(str(torch_in(tmp_path / "chosen")))[-1].path == str(tmp_path / "chosen")


def test_loading_reports_what_is_broken(monkeypatch):
    def load(name):
        if name == "numba":
            raise ImportError("DLL load failed")
        if name == TORCH.name:
            raise ModuleNotFoundError("No module named 'torch'", name="torch")
        return sys.modules[__name__]

    monkeypatch.setattr(packages.importlib, "import_module", load)
    found = {entry["name"]: entry for entry in packages.loaded()}
    assert found["numba"]["problem"] == "ImportError: DLL load failed" and found["torch"]["problem"] == "not found"
    assert found["trimesh"]["path"] == __file__
