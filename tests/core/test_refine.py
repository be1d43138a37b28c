"""Refinement: each stage lowers the error of its prefix; only the sender needs torch."""
from functools import cache

import numpy as np
import pytest

from npm_blender.core.codec import compress, open_stream
from npm_blender.core.lod import build_lod
from npm_blender.core.mesh import Frame, TriMesh
from npm_blender.core.metrics import evaluate
from npm_blender.core.refine import Refiner, Target, _added
from npm_blender.core.settings import CompressSettings, LodSettings
from npm_blender.core.subdivide import hierarchy
from npm_blender.core.surface import Surface
from npm_blender.core.weights import load
from tests.shapes import bumpy, grid

SHAPES = {"closed": bumpy(4), "open": grid(40)}
LOD = LodSettings(base_faces=100)


@cache
def errors(name, steps):
    opened = open_stream(compress(SHAPES[name], CompressSettings(lod=LOD, refine_steps=steps)).data)
    return np.array([evaluate(opened.decode(k), SHAPES[name], 20_000).d_pm for k in (0, 40, 400, opened.features)])


@pytest.mark.parametrize("name", SHAPES)
def test_refined_streams_are_better_at_every_budget(name):
    assert (errors(name, 12) < errors(name, 0)).all()


@pytest.mark.parametrize("name", SHAPES)
def test_more_features_are_better(name):
    assert (np.diff(errors(name, 12)) < 0).all()


def test_refinement_is_deterministic():
    settings = CompressSettings(lod=LOD, refine_steps=3)
    assert compress(SHAPES["open"], settings).data == compress(SHAPES["open"], settings).data


def test_features_that_do_harm_are_left_out_and_the_others_stay():
    """One feature that helps and one that spoils another corner of the mesh: pruning keeps the first."""
    mesh = SHAPES["closed"]
    unit = TriMesh(Frame.of(mesh.V).to_unit(mesh.V), mesh.F)
    lod = build_lod(unit, LodSettings(base_faces=100, levels=2))
    levels = hierarchy(lod.F0, len(lod.V0), 2)
    refiner = Refiner(load().params, Target(unit, Surface(unit), lod, levels), 1)
    base, steps = refiner.B.array(lod.V0), np.array([0.25, 0.25], np.float32)
    none = [refiner.torch.zeros(len(level.F), 8) for level in levels[:-1]]
    error = [float(refiner._face_errors(base, none)[0].mean())]
    single = {}
    for face in range(0, 100, 3):  # what each of some features does alone
        news = [n.clone() for n in none]
        news[0][face] = 2.0
        single[face] = float(refiner._face_errors(base, _added(none, news, steps))[0].mean()) - error[0]
    good, bad = min(single, key=single.get), max(single, key=single.get)
    assert single[good] < 0 < single[bad]
    both = [n.clone() for n in none]
    both[0][[good, bad]] = 2.0
    kept = refiner._pruned(base, none, both, steps)
    assert kept[0][good].all() and not kept[0][bad].any() and not kept[1].any()
