"""Decoder, and encoder with it: parity of the backends, invariances, prefixes, any number of levels."""
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.mesh.subdivision import hierarchy
from npm_blender.core.network.decoder import decode
from npm_blender.core.network.encoder import details, encode
from npm_blender.core.network.numpy_backend import NUMPY
from npm_blender.core.network.parameters import NetworkConfig, initial_parameters, map_tree
from npm_blender.core.network.torch_backend import TorchBackend
from tests.core.network.samples import SHAPES, busy_parameters, indices, sequence

pytestmark = pytest.mark.torch

TORCH = TorchBackend()


@pytest.mark.parametrize("name", SHAPES)
def test_numpy_and_torch_agree(name):
    lods, V = sequence(SHAPES[name], 3)
    params = busy_parameters()
    f = encode(NUMPY, params, V, indices(NUMPY, lods))
    out = decode(NUMPY, params, V[0], f, indices(NUMPY, lods)[:-1])
    tree = map_tree(TORCH.array, params)
    ft = encode(TORCH, tree, [TORCH.array(v) for v in V], indices(TORCH, lods))
    again = decode(TORCH, tree, TORCH.array(V[0]), [TORCH.array(x) for x in f], indices(TORCH, lods)[:-1])
    assert [x.shape for x in f] == [(len(level.F), 8) for level in lods[:-1]]
    assert all(np.abs(a - b.numpy()).max() < 1e-3 * max(1, np.abs(a).max()) for a, b in zip(f, ft, strict=True))
    assert all(np.abs(a - b.numpy()).max() < 1e-5 for a, b in zip(out, again, strict=True))


@pytest.mark.parametrize("name", SHAPES)
def test_fewer_levels_are_the_first_of_more(name):
    lods, V = sequence(SHAPES[name], 3)
    params, mesh = busy_parameters(), indices(NUMPY, lods)
    f = encode(NUMPY, params, V, mesh)
    out = decode(NUMPY, params, V[0], f, mesh[:-1])
    assert (decode(NUMPY, params, V[0], f[:2], mesh[:2])[-1] == out[1]).all()


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**31), st.floats(0, 1))
def test_every_subset_of_features_decodes(seed, share):
    lods, V = sequence(SHAPES["torus"], 3)
    params, mesh = busy_parameters(), indices(NUMPY, lods)
    random = np.random.default_rng(seed)
    f = [x * (random.random(len(x)) < share)[:, None] for x in encode(NUMPY, params, V, mesh)]
    out = decode(NUMPY, params, V[0], f, mesh[:-1])[-1]
    assert np.isfinite(out).all() and len(out) == lods[-1].n


@pytest.mark.parametrize("name", SHAPES)
def test_decoding_commutes_with_motion_and_scale(name):
    lods, V = sequence(SHAPES[name], 2)
    params, mesh = busy_parameters(), indices(NUMPY, lods)
    f = encode(NUMPY, params, V, mesh)
    q, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    q *= np.sign(np.linalg.det(q))
    a = decode(NUMPY, params, V[0], f, mesh[:-1])[-1]
    b = decode(NUMPY, params, (0.5 * V[0] @ q.T + 0.1).astype(np.float32), f, mesh[:-1])[-1]
    assert np.abs(0.5 * a @ q.T + 0.1 - b).max() < 1e-4


def test_the_order_of_faces_does_not_matter():
    mesh = SHAPES["torus"]
    order = np.random.default_rng(6).permutation(len(mesh.F))
    params = busy_parameters()
    out = []
    for F in (mesh.F, mesh.F[order]):
        lods = hierarchy(F, len(mesh.V), 2)
        none = [np.zeros((len(level.F), 8), np.float32) for level in lods[:-1]]
        out.append(decode(NUMPY, params, mesh.V.astype(np.float32), none, indices(NUMPY, lods)[:-1])[-1])
    assert np.abs(out[0] - out[1]).max() < 1e-5


@pytest.mark.parametrize("levels", [1, 2, 4, 5])
def test_more_levels_than_trained_steps(levels):
    lods, V = sequence(SHAPES["sphere"], levels)
    params, mesh = busy_parameters(), indices(NUMPY, lods)
    f = encode(NUMPY, params, V, mesh)
    out = decode(NUMPY, params, V[0], f, mesh[:-1])
    assert len(out) == levels and np.isfinite(out[-1]).all()


@pytest.mark.parametrize("name", ["sphere", "torus"])
def test_untrained_network_with_direct_path_already_reconstructs(name):
    """Features of the initial weights carry offsets along the normal, so decoding with them beats decoding without."""
    lods, V = sequence(SHAPES[name], 2)
    params, mesh = initial_parameters(NetworkConfig()), indices(NUMPY, lods)
    for step in params["encoder"]:
        step["features"][:] = 0
    f = encode(NUMPY, params, V, mesh)
    with_f = decode(NUMPY, params, V[0], f, mesh[:-1])[0]
    without = decode(NUMPY, params, V[0], [0 * x for x in f], mesh[:-1])[0]
    w = [details(NUMPY, V[0], v, mesh[0])[:, 2] for v in (with_f, without, V[1])]
    assert np.abs(w[0] - w[2]).mean() < 0.2 * np.abs(w[1] - w[2]).mean()
