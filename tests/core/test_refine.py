"""Refinement: each stage lowers the error of its prefix; only the sender needs torch."""
from functools import cache

import numpy as np
import pytest

from npm_blender.core.codec import compress, open_stream
from npm_blender.core.metrics import evaluate
from npm_blender.core.settings import CompressSettings, LodSettings
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
