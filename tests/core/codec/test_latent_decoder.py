"""The paper's streams: the network's pass, done again only where a change is seen; weights that must be there."""
import numpy as np
import pytest

from npm_blender.core.bitstream import read_stream
from npm_blender.core.codec import latent_decoder, open_stream
from npm_blender.core.codec.latent_decoder import LatentDecoder
from npm_blender.core.errors import WeightsError
from npm_blender.core.mesh import hierarchy
from npm_blender.core.network import FEATURES, NUMPY, MeshIndex, decode, load_weights
from tests.core.bitstream.samples import latent_sample
from tests.core.codec.streams import known_latents

DATA = known_latents().data
READ = read_stream(DATA)


@pytest.mark.parametrize("count", [0, 41, 100])
def test_vertices_are_those_of_the_whole_pass(count):
    levels = hierarchy(READ.F0, len(READ.grid), 3)
    latents = [np.zeros((len(level.F), FEATURES), np.float32) for level in levels[:-1]]
    steps = np.asarray(READ.header.coding.steps, np.float32)
    for level, face, value in zip(READ.details.level[:count], READ.details.face, READ.details.value):
        latents[level][face] = value.astype(np.float32) * steps[level]
    meshes = [MeshIndex.of(NUMPY, level) for level in levels[:-1]]
    expected = decode(NUMPY, load_weights().params, NUMPY.array(READ.V0), latents, meshes)
    found = LatentDecoder(READ)
    assert all(np.array_equal(found.vertices(count, i + 1), V) for i, V in enumerate(expected))
    assert np.array_equal(found.vertices(count, 0), NUMPY.array(READ.V0)) and found.scalars(count) == 8 * count


def test_only_steps_that_see_a_change_are_done_again(monkeypatch):
    opened, done, predict = open_stream(DATA), [], latent_decoder.predict
    finest = int(np.flatnonzero(READ.details.level == opened.levels - 1)[-1])
    monkeypatch.setattr(latent_decoder, "predict", lambda *given: done.append(given[2]) or predict(*given))
    before = opened.decode(finest)
    assert done == list(range(opened.levels))
    after = opened.decode(finest + 1)
    assert done == [*range(opened.levels), opened.levels - 1] and (before.V != after.V).any()
    opened.decode(0)
    assert done == [*range(opened.levels), opened.levels - 1, *range(opened.levels)]


def test_weights_that_are_not_here_are_named():
    with pytest.raises(WeightsError, match="default"):
        open_stream(latent_sample(2, across=2).data)
    with pytest.raises(WeightsError, match="install the version of the extension that wrote this file"):
        open_stream(latent_sample(2, across=2, model_id=load_weights().model_id).data)
