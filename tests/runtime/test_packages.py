"""Which packages are there, found without loading them, and loaded to see whether they work."""
import subprocess
import sys

from npm_blender.runtime import packages


def test_looking_loads_nothing():
    code = ("import sys; from npm_blender.runtime import packages; found = packages.found(); "
            "print([s.package.name for s in found if not s.problem], {'numba', 'numpy'} & set(sys.modules))")
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "'numba'" in said and said.strip().endswith("set()")


def test_a_missing_package_has_a_problem_and_a_remedy(monkeypatch):
    find = packages.importlib.util.find_spec
    monkeypatch.setattr(packages.importlib.util, "find_spec", lambda name: None if name == "numba" else find(name))
    status = {s.package.name: s for s in packages.found()}
    assert status["numba"].problem == "not found" and status["numba"].package.remedy and not status["numpy"].problem
    assert status["numpy"].version and not status["numba"].version


def test_loading_reports_what_is_broken(monkeypatch):
    def load(name):
        if name == "numba":
            raise ImportError("DLL load failed")
        if name == "pytetwild":
            raise ModuleNotFoundError("No module named 'pytetwild'", name="pytetwild")
        return sys.modules[__name__]

    monkeypatch.setattr(packages.importlib, "import_module", load)
    found = {entry["name"]: entry for entry in packages.loaded()}
    assert found["numba"]["problem"] == "ImportError: DLL load failed" and found["pytetwild"]["problem"] == "not found"
    assert found["trimesh"]["path"] == __file__
