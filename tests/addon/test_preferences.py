"""Preferences: what they hold reaches the worker process, and what they say of the packages and the cache is true."""
import sys
from pathlib import Path

import bpy
import pytest

from .conftest import refusal
from .test_compress import leftovers


@pytest.fixture
def chosen(package, part, tmp_path):
    """The preferences, at their defaults but for a cache of their own, and so again afterwards."""
    preferences = bpy.context.preferences.addons[package].preferences
    preferences.cache = str(tmp_path / "chosen")
    yield preferences
    for name in ("threads", "cache", "checked"):
        preferences.property_unset(name)
    part("preferences").forget_status()


def environment_of(job) -> dict[str, str]:
    """The environment of a job's process, asked of the system."""
    said = b""
    while not said:  # while it starts, it has none
        said = Path(f"/proc/{job._process.pid}/environ").read_bytes()
    return dict(line.split("=", 1) for line in said.decode().split("\0") if "=" in line)


def test_the_defaults_leave_the_choice_to_the_extension(part, package):
    settings = part("preferences").worker_settings()
    assert settings.threads == 0 and settings.cache == bpy.utils.extension_path_user(package, path="cache")
    assert "OMP_NUM_THREADS" not in settings.variables()


@pytest.mark.skipif(sys.platform != "linux", reason="asks the kernel for a process's environment")
def test_all_of_it_reaches_the_worker(part, chosen, tmp_path, as_installed):
    chosen.threads = 3
    settings = part("preferences").worker_settings()
    job = part("jobs").CheckJob(bpy.app.tempdir, settings)
    try:
        said = environment_of(job)
    finally:
        job.cancel()
    assert said["OMP_NUM_THREADS"] == said["NUMBA_NUM_THREADS"] == "3"
    cache = str(tmp_path / "chosen" / "npm_blender")
    assert said["NUMBA_CACHE_DIR"] == str(Path(cache, "compiled")) and said["NPMESH_CACHE"] == cache


def test_the_button_clears_the_chosen_cache_and_nothing_else(chosen, tmp_path):
    compiled = tmp_path / "chosen" / "npm_blender" / "compiled" / "module_0"
    compiled.mkdir(parents=True)
    for name in ("code.nbi", "code.1.nbc", "mine.txt"):
        (compiled / name).write_text("content")
    assert bpy.ops.preferences.npmesh_clear_cache() == {"FINISHED"}
    assert [p.name for p in (tmp_path / "chosen").rglob("*") if p.is_file()] == ["mine.txt"]


def test_a_cache_that_cannot_be_made_counts_as_not_chosen(part, package, chosen, tmp_path):
    (tmp_path / "file").touch()
    chosen.cache = str(tmp_path / "file")
    assert part("preferences").cache_folder() == bpy.utils.extension_path_user(package, path="cache")


def test_the_check_asks_the_worker(part, chosen, as_installed):
    assert bpy.ops.preferences.npmesh_check() == {"FINISHED"}
    lines = chosen.checked.splitlines()
    assert [line.split(" ")[0].rstrip(":") for line in lines] == ["numpy", "numba", "trimesh", "pytetwild"]
    assert not leftovers()


def test_nothing_is_cleared_under_a_running_job(part, chosen):
    job = part("jobs").CheckJob(bpy.app.tempdir, part("preferences").worker_settings())
    try:
        assert "Expected no running job" in refusal(bpy.ops.preferences.npmesh_clear_cache)
        assert "Expected no running job" in refusal(bpy.ops.preferences.npmesh_check)
    finally:
        job.cancel()


class Drawn:
    """Stands in for a UILayout: takes every call, and remembers the labels."""

    def __init__(self, labels: list[str]) -> None:
        self.__dict__["labels"] = labels

    def label(self, text="", **_):
        self.labels.append(text)

    def __getattr__(self, name):
        return lambda *_, **__: Drawn(self.labels)

    def __setattr__(self, name, value):
        pass


def drawn(part, preferences) -> list[str]:
    """What the preferences show."""
    labels: list[str] = []

    class Shown:
        layout = Drawn(labels)
        threads, checked = preferences.threads, preferences.checked

    part("preferences").NpmPreferences.draw(Shown(), bpy.context)
    return labels


def test_a_missing_package_is_named_with_its_remedy(part, chosen, monkeypatch):
    packages = part("runtime.packages")
    find = packages.importlib.util.find_spec
    monkeypatch.setattr(packages.importlib.util, "find_spec",
                        lambda name: None if name == "numba" else find(name))
    part("preferences").forget_status()
    labels = drawn(part, chosen)
    assert "Not found" in labels and any("Disable and enable the extension" in text for text in labels)
    assert any(text.startswith("The cache holds") for text in labels)
