import numpy as np
import pytest

from npm_blender.core.mesh.subdivision import midpoints
from npm_blender.core.network.decoder import feature_slots
from npm_blender.core.network.encoder import details, encode, features_of_slots
from npm_blender.core.network.frames import edge_frames
from npm_blender.core.network.input_features import geometry_features
from npm_blender.core.network.numpy_backend import NUMPY
from tests.core.network.samples import SHAPES, busy_parameters, indices, sequence


@pytest.mark.parametrize("name", SHAPES)
def test_details_are_the_offsets_as_both_half_edges_see_them(name):
    lods, V = sequence(SHAPES[name], 1)
    mesh = indices(NUMPY, lods)[0]
    seen = details(NUMPY, V[0], V[1], mesh)[mesh.left]  # along, across, up
    x, y, z, length = edge_frames(NUMPY, V[0], mesh)
    offset = sum(axis * seen[:, k, None] for k, axis in enumerate((x, y, z))) * length / 20
    assert np.allclose(midpoints(V[0], lods[0])[mesh.n:] + offset, V[1][mesh.n:], atol=1e-5)
    inner = mesh.left != mesh.right
    other = details(NUMPY, V[0], V[1], mesh)[mesh.right]
    assert np.array_equal(other[inner], seen[inner] * [-1, -1, 1])


def test_slots_keep_the_features_of_a_face():
    f = np.random.default_rng(0).normal(size=(5, 8)).astype(np.float32)
    assert np.allclose(features_of_slots(NUMPY, feature_slots(NUMPY, f)), f, atol=1e-6)


def test_details_that_are_known_are_not_looked_for_again():
    lods, V = sequence(SHAPES["torus"], 2)
    mesh, params = indices(NUMPY, lods), busy_parameters()
    known = ([geometry_features(NUMPY, v, m) for v, m in zip(V[1:], mesh[1:], strict=True)],
             [details(NUMPY, V[1], V[2], mesh[1])])
    assert all(np.array_equal(a, b) for a, b in zip(encode(NUMPY, params, V, mesh), encode(NUMPY, params, V, mesh, known),
                                                    strict=True))
