"""Threads and folders: what is chosen is in the worker's environment."""
import os
from pathlib import Path

import pytest

from npm_blender.core import parallel
from npm_blender.core.cleaning import result_cache
from npm_blender.jobs.machine import POOLS, WorkerSettings


@pytest.mark.parametrize("threads", [1, 3])
def test_a_number_of_threads_is_for_every_library(monkeypatch, threads):
    said = WorkerSettings(threads).variables()
    assert said == dict.fromkeys(POOLS, str(threads))
    monkeypatch.setenv("OMP_NUM_THREADS", said["OMP_NUM_THREADS"])
    assert parallel.threads() == threads


def test_nothing_chosen_says_nothing():
    assert WorkerSettings().variables() == {}


def test_the_cache_is_for_compiled_code_and_for_results(monkeypatch):
    said = WorkerSettings(cache="/a/cache").variables()
    assert said["NUMBA_CACHE_DIR"] == str(Path("/a/cache", "compiled"))
    monkeypatch.setenv("NPMESH_CACHE", said["NPMESH_CACHE"])
    assert result_cache.user_cache() == Path("/a/cache")


def test_a_process_that_is_the_worker_is_itself_again_afterwards():
    before = dict(os.environ)
    with WorkerSettings(2, cache="/a/cache").in_this_process():
        assert parallel.threads() == 2 and result_cache.user_cache() == Path("/a/cache")
    assert dict(os.environ) == before
