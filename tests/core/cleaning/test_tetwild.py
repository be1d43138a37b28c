import sys
from pathlib import Path

import numpy as np
import pytest

from npm_blender.core.cleaning import result_cache, tetwild
from npm_blender.core.cleaning.cleanup import clean
from npm_blender.core.errors import Cancelled, DependencyError, MeshError
from npm_blender.core.mesh.topology import topology_of
from tests.meshes.dirty_meshes import joined, plane, sphere, volume, without


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """The cache in the test's folder, and an envelope ten times as coarse, for speed."""
    monkeypatch.setattr(result_cache, "user_cache", lambda: tmp_path / "cache")
    monkeypatch.setattr(tetwild, "ENVELOPE", 1e-2)
    return tmp_path / "cache" / "tetwild"


def overlapping():
    return joined(sphere(1), without(sphere(1, at=(0.9, 0, 0)), [0]))


def test_without_its_package_it_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pytetwild", None)
    with pytest.raises(DependencyError, match="pip install pytetwild==0.2.3"):
        clean(sphere(), "tetwild")


@pytest.mark.slow
def test_joins_what_overlaps_leaves_no_file_and_comes_out_the_same_again(tmp_path, monkeypatch, cache):
    pytest.importorskip("pytetwild")
    folder = tmp_path / "current"
    folder.mkdir()
    monkeypatch.chdir(folder)
    result, report = clean(overlapping(), "tetwild")
    assert "remeshed with TetWild" in report.summary and "earlier run" not in report.summary
    assert list(folder.iterdir()) == [] and report.after.problems == ()
    assert topology_of(result.F).components == 1 and topology_of(result.F).border_loops == 0
    assert volume(sphere()) * 1.3 < volume(result) < volume(sphere()) * 1.8
    assert len(list(cache.iterdir())) == 1
    monkeypatch.setattr(tetwild, "_run", None)  # not called again
    again, second = clean(overlapping(), "tetwild")
    assert np.array_equal(again.V, result.V) and np.array_equal(again.F, result.F)
    assert "the result of an earlier run" in second.summary


def test_another_mesh_or_envelope_is_another_entry_and_a_damaged_one_is_made_again(monkeypatch, cache):
    made = []

    def run(folder, progress, limit):
        made.append(folder)
        np.save(Path(folder, "points.npy"), np.eye(4)[:, :3])
        np.save(Path(folder, "tetrahedra.npy"), np.array([[0, 1, 2, 3]]))

    pytest.importorskip("pytetwild")
    monkeypatch.setattr(tetwild, "_run", run)
    m = sphere(1)
    for _ in range(2):
        V, F, kept = tetwild.remesh(m.V, m.F)
    assert kept and len(made) == 1 and len(F) == 4
    assert not tetwild.remesh(m.V + 1e-9, m.F)[2] and not tetwild.remesh(m.V, m.F[1:])[2]
    monkeypatch.setattr(tetwild, "ENVELOPE", 2e-2)
    assert not tetwild.remesh(m.V, m.F)[2] and len(made) == 4
    for path in cache.iterdir():
        path.write_bytes(path.read_bytes()[:-60])
    assert not tetwild.remesh(m.V, m.F)[2] and tetwild.remesh(m.V, m.F)[2]
    for path in cache.iterdir():
        assert result_cache.keep(cache, path.stem, V=np.full((3, 3), np.nan), F=np.eye(3, dtype=int))
    assert not tetwild.remesh(m.V, m.F)[2]


def test_is_ended_after_its_limit_and_keeps_nothing(cache):
    pytest.importorskip("pytetwild")
    with pytest.raises(MeshError, match="within 0 s"):
        tetwild.remesh(sphere(4).V, sphere(4).F, limit=0.0)
    assert not cache.exists()


def test_an_open_sheet_is_named():
    pytest.importorskip("pytetwild")
    with pytest.raises(MeshError, match="TetWild"):
        clean(plane(), "tetwild")


def test_cancelled():
    pytest.importorskip("pytetwild")

    def cancel(fraction, message):
        if "TetWild" in message:
            raise Cancelled("Cancelled")
    with pytest.raises(Cancelled):
        clean(sphere(4), "tetwild", cancel)
