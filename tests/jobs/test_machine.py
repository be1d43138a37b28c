"""Threads, device and folders: what goes into the worker's environment comes out of it."""
import os
import sys
from pathlib import Path

import pytest

from npm_blender.core.cleaning import result_cache
from npm_blender.core.errors import SettingsError
from npm_blender.core.settings import ComputeSettings
from npm_blender.jobs.machine import WorkerSettings, compute_settings


@pytest.mark.parametrize("compute", [ComputeSettings(), ComputeSettings(threads=3), ComputeSettings(2, "gpu")])
def test_the_worker_reads_what_was_said(compute):
    said = WorkerSettings(compute).variables()
    assert compute_settings(said) == compute
    assert said.get("OMP_NUM_THREADS") == (str(compute.threads) if compute.threads else None)


def test_nothing_said_means_the_defaults():
    assert compute_settings({}) == ComputeSettings()


@pytest.mark.parametrize("said", [{"NPMESH_THREADS": "many"}, {"NPMESH_THREADS": "-1"}, {"NPMESH_THREADS": ""},
                                  {"NPMESH_DEVICE": "toaster"}, {"NPMESH_THREADS": "99999"}])
def test_what_cannot_be_is_refused(said):
    with pytest.raises(SettingsError, match="Expected"):
        compute_settings(said)


def test_the_cache_is_for_compiled_code_and_for_results(monkeypatch):
    said = WorkerSettings(cache="/a/cache").variables()
    assert said["NUMBA_CACHE_DIR"] == str(Path("/a/cache", "compiled"))
    monkeypatch.setenv("NPMESH_CACHE", said["NPMESH_CACHE"])
    assert result_cache.user_cache() == Path("/a/cache")


def test_torch_is_looked_for_last():
    assert WorkerSettings(torch_path="/t").packages(["/own", "/other"]) == ["/own", "/other", "/t"]
    assert WorkerSettings(torch_path="/own").packages(["/own", "/other"]) == ["/own", "/other"]
    assert WorkerSettings().packages(["/own"]) == ["/own"]


def test_a_process_that_is_the_worker_is_itself_again_afterwards():
    before = dict(os.environ), list(sys.path)
    with WorkerSettings(ComputeSettings(2), cache="/a/cache", torch_path="/t").in_this_process():
        assert compute_settings() == ComputeSettings(2) and sys.path[-1] == "/t"
    assert (dict(os.environ), list(sys.path)) == before
