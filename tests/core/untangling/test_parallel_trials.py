import numpy as np
import pytest

from npm_blender.core.decimation.qem import decimate
from npm_blender.core.levels.lod_sequence import build_levels
from npm_blender.core.untangling import parallel_trials as module
from npm_blender.core.untangling.parallel_trials import ParallelTrials
from npm_blender.core.untangling.trial import commit
from tests.meshes.lod_meshes import plate

from .test_perturbation import flipped
from .test_trial import Flat


@pytest.mark.parametrize("count", ["2", "3", "4"])
def test_the_same_points_on_any_number_of_threads(count, monkeypatch):
    asked = []
    plain = ParallelTrials.try_perturbations
    monkeypatch.setattr(ParallelTrials, "try_perturbations", lambda self, faces, trials, covered: (
        asked.append(trials), plain(self, faces, trials, covered))[1])
    decimation = decimate(plate(), 100)
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    one = build_levels(decimation, 3)
    monkeypatch.setenv("OMP_NUM_THREADS", count)
    many = build_levels(decimation, 3)
    assert asked
    assert np.array_equal(one.V, many.V) and np.array_equal(one.source_face, many.source_face)


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_every_copy_of_the_points_is_the_same_after_each_success(count, monkeypatch):
    monkeypatch.setattr(module, "threads", lambda: count)
    flat = Flat()
    flat.region.set_work(10**6)
    rng = np.random.default_rng(3)
    free = np.flatnonzero(~flat.rings.fixed)
    with ParallelTrials(flat.surface, flat.rings, flat.points, flat.region, 16) as parallel:
        for v in rng.choice(free, 6, replace=False):
            flat.region.vertices[0] = v
            commit(flat.region, 1)
            flat.points.P[v, :2] += rng.uniform(-0.2, 0.2, 2)
            faces = np.flatnonzero(flipped(flat))
            while len(faces):
                before = flipped(flat).sum()
                at = parallel.try_perturbations(faces, 16, 0.5)
                assert (at >= 0) == (flipped(flat).sum() < before)
                faces = faces[at + 1:] if at >= 0 else faces[:0]
                for copy in parallel._points[1:]:
                    assert all(np.array_equal(a, b) for a, b in zip(flat.points, copy, strict=True))
        assert len(parallel._points) == count
