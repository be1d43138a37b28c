"""Refinement: each stage lowers the error of its prefix; only the sender needs torch."""
import sys
from functools import cache

import numpy as np
import pytest

from npm_blender.core import network
from npm_blender.core.codec import compress, open_stream
from npm_blender.core.errors import DependencyError, SettingsError
from npm_blender.core.evaluation.metrics import evaluate
from npm_blender.core.geometry.closest_point import ClosestPoints
from npm_blender.core.levels.lod_sequence import build_lod
from npm_blender.core.mesh.subdivision import hierarchy
from npm_blender.core.mesh.triangle_mesh import TriMesh, UnitFrame
from npm_blender.core.network import torch_backend
from npm_blender.core.network.weights import load_weights
from npm_blender.core.refinement.descent import Target
from npm_blender.core.refinement.offset_fit import OffsetFit
from npm_blender.core.refinement.refiner import Refiner, _values
from npm_blender.core.settings import CompressSettings, ComputeSettings, LodSettings
from tests.meshes.shapes import bumpy, grid

pytestmark = pytest.mark.torch

SHAPES = {"closed": bumpy(4), "open": grid(40)}
LOD = LodSettings(base_faces=100, levels=2)
STEPS = [0.25, 0.25]  # of latents of two levels


@cache
def errors(name, steps):
    opened = open_stream(compress(SHAPES[name], CompressSettings(lod=LOD, refine_steps=steps)).data)
    return np.array([evaluate(opened.decode(k), SHAPES[name], 20_000).d_pm for k in (0, 40, 400, opened.features)])


def in_unit_frame(name):
    """A shape in the unit frame, its LoD sequence of two levels above 100 faces, and their connectivity."""
    mesh = SHAPES[name]
    unit = TriMesh(UnitFrame.of(mesh.V).to_unit(mesh.V), mesh.F)
    lod = build_lod(unit, LodSettings(base_faces=100, levels=2))
    return unit, lod, hierarchy(lod.F0, len(lod.V0), 2)


@pytest.mark.slow
@pytest.mark.parametrize("name", SHAPES)
def test_refined_streams_are_better_at_every_budget(name):
    assert (errors(name, 12) < errors(name, 0)).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", SHAPES)
def test_more_features_are_better(name):
    assert (np.diff(errors(name, 12)) < 0).all()


@pytest.mark.slow
def test_refinement_is_deterministic():
    settings = CompressSettings(lod=LOD, refine_steps=3)
    assert compress(SHAPES["open"], settings).data == compress(SHAPES["open"], settings).data


def test_features_that_do_harm_are_left_out_and_the_others_stay():
    """One feature that helps and one that spoils another corner of the mesh: pruning keeps the first."""
    unit, lod, levels = in_unit_frame("closed")
    refiner = Refiner(load_weights().params, Target(unit, ClosestPoints(unit), lod, levels), 1)
    base = refiner.B.array(lod.V0)
    none = [refiner.torch.zeros(len(level.F), 8) for level in levels[:-1]]
    error = [float(refiner.face_errors(base, none)[0].mean())]
    single = {}
    for face in range(0, 100, 3):  # what each of some features does alone
        news = [n.clone() for n in none]
        news[0][face] = 2.0
        single[face] = float(refiner.face_errors(base, _values(news, STEPS))[0].mean()) - error[0]
    good, bad = min(single, key=single.get), max(single, key=single.get)
    assert single[good] < 0 < single[bad]
    both = [n.clone() for n in none]
    both[0][[good, bad]] = 2.0
    kept = refiner._pruned(base, both, STEPS)
    assert kept[0][good].all() and not kept[0][bad].any() and not kept[1].any()


class NoSurface:
    """Answers at once what a ClosestPoints would search for."""

    def closest(self, P):
        return np.zeros(len(P)), np.zeros((len(P), 3)), np.zeros(len(P), np.int32)


@pytest.mark.slow
def test_everything_stays_on_the_chosen_device(monkeypatch):
    """torch's device "meta" has shapes and no numbers: an operation with a tensor of the processor fails on it."""
    monkeypatch.setattr(network, "torch_device", lambda wanted: {"gpu": "meta", "cpu": "cpu"}[wanted])
    fetched = []

    def numpy(self, x):
        assert x.device.type == "meta"
        fetched.append(x.shape)
        if x.dtype.is_floating_point:
            return np.random.default_rng(0).random(x.shape, np.float32)
        return np.zeros(x.shape, np.int32)

    monkeypatch.setattr(torch_backend.TorchBackend, "numpy", numpy)
    unit, lod, levels = in_unit_frame("closed")
    compute = ComputeSettings(device="gpu")
    refiner = Refiner(load_weights().params, Target(unit, NoSurface(), lod, levels), 1, compute=compute)
    assert refiner.base(lod.V0).shape == lod.V0.shape
    features = [np.ones((len(level.F), 8), np.float32) for level in levels[:-1]]
    assert [f.shape for f in refiner.level_by_level(lod.V0, features, 1.0)] == [f.shape for f in features]
    order = np.arange(sum(map(len, features)))
    ints = refiner.latents(lod.V0, features, order, np.array(STEPS, np.float32), 1.0)
    assert [i.shape for i in ints] == [f.shape for f in features] and fetched
    edges = [np.ones(len(level.edges), np.float32) for level in levels[:-1]]
    fit = OffsetFit(refiner, lod.V0, features, edges, np.array(STEPS, np.float32), 1e-5)
    for offsets in (fit.whole(edges), fit.staged(edges, [0.5 * e for e in edges])):
        assert [o.shape for o in offsets] == [e.shape for e in edges]


@pytest.mark.slow
def test_threads_and_a_gpu_that_is_missing():
    import torch

    before = torch.get_num_threads()
    settings = CompressSettings(lod=LodSettings(base_faces=100, levels=1), refine_steps=1)
    try:
        report = compress(SHAPES["open"], settings, compute=ComputeSettings(threads=3, device="gpu")).report
        assert torch.get_num_threads() == 3
    finally:
        torch.set_num_threads(before)
    note = "refined on the processor, as torch finds no GPU"
    assert (note in report.messages) == (torch_backend.torch_device("gpu") == "cpu")


@pytest.mark.parametrize("wrong", [{"threads": -1}, {"threads": True}, {"device": "cuda"}])
def test_compute_settings_are_checked(wrong):
    with pytest.raises(SettingsError, match="Expected"):
        ComputeSettings(**wrong)


def test_a_torch_that_does_not_load_is_one_line(monkeypatch):
    """As on Windows without the libraries that torch needs."""
    class Broken:
        def find_spec(self, name, path=None, target=None):
            if name == "torch":
                raise OSError("[WinError 126] c10.dll\nor one of its dependencies")

    unit, lod, levels = in_unit_frame("closed")
    monkeypatch.setattr(sys, "meta_path", [Broken(), *sys.meta_path])
    monkeypatch.delitem(sys.modules, "torch")
    with pytest.raises(DependencyError, match=r"Expected torch to load, found: \[WinError 126\] c10.dll or one of its"):
        Refiner(load_weights().params, Target(unit, NoSurface(), lod, levels), 1)
