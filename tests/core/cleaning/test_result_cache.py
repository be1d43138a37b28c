import os
import sys

import numpy as np
import pytest

from npm_blender.core.cleaning import result_cache
from npm_blender.core.settings import CACHE_VARIABLE


@pytest.fixture
def cache(tmp_path):
    return tmp_path / "cache"


def test_the_cache_drops_what_was_not_used_for_longest(cache, monkeypatch):
    entry = {"V": np.zeros(1000)}  # some 8.3 kB
    monkeypatch.setattr(result_cache, "LIMIT", 20_000)
    for k, name in enumerate(("a", "b")):
        assert result_cache.keep(cache, name, **entry)
        os.utime(cache / f"{name}.npz", (k, k))
    assert np.array_equal(result_cache.load(cache, "a")["V"], entry["V"])  # used now, so b is the oldest
    assert result_cache.keep(cache, "c", **entry)
    assert sorted(p.name for p in cache.iterdir()) == ["a.npz", "c.npz"]
    assert not result_cache.keep(cache, "d", V=np.zeros(10_000))  # alone too large
    assert result_cache.load(cache, "b") is None


def test_a_cache_that_cannot_be_written_keeps_nothing_and_does_not_fail(tmp_path):
    (tmp_path / "file").write_text("")
    assert not result_cache.keep(tmp_path / "file" / "cache", "a", V=np.zeros(3))
    assert result_cache.load(tmp_path / "file" / "cache", "a") is None


def test_a_digest_sees_values_shapes_and_types():
    a = np.arange(6.0)
    seen = {result_cache.digest(*parts) for parts in (
        ("x", a), ("y", a), ("x", a + 1), ("x", a.reshape(2, 3)), ("x", a.astype(np.float32)), ("x", "x"), ("xx",))}
    assert len(seen) == 7 and result_cache.digest("x", a) in seen


@pytest.mark.parametrize("platform, variable", [("linux", "XDG_CACHE_HOME"), ("win32", "LOCALAPPDATA")])
def test_the_folder_is_among_the_users_caches(platform, variable, monkeypatch, tmp_path):
    monkeypatch.delenv(CACHE_VARIABLE, raising=False)
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setenv(variable, str(tmp_path))
    assert result_cache.user_cache() == tmp_path / "npm_blender"
