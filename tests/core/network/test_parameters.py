import numpy as np
import pytest

from npm_blender.core.network.decoder import decode
from npm_blender.core.network.encoder import encode
from npm_blender.core.network.numpy_backend import NUMPY
from npm_blender.core.network.parameters import NetworkConfig, flatten_tree, folded, initial_parameters, unflatten_tree
from tests.core.network.samples import SHAPES, busy_parameters, indices, sequence


@pytest.mark.parametrize("name", SHAPES)
def test_folding_batch_normalization_changes_nothing(name):
    lods, V = sequence(SHAPES[name], 2)
    params = busy_parameters()
    mesh = indices(NUMPY, lods)
    f = encode(NUMPY, params, V, mesh)
    short = folded(params)
    assert not any("gamma" in k for k in flatten_tree(short))
    assert all(np.allclose(a, b, atol=1e-4) for a, b in zip(f, encode(NUMPY, short, V, mesh), strict=True))
    assert np.allclose(decode(NUMPY, params, V[0], f, mesh[:-1])[-1], decode(NUMPY, short, V[0], f, mesh[:-1])[-1], atol=1e-5)


def test_flatten_and_unflatten_are_inverse():
    tree = initial_parameters(NetworkConfig((4, 4), (4,)))
    again = unflatten_tree(flatten_tree(tree))
    assert flatten_tree(again).keys() == flatten_tree(tree).keys()
    assert isinstance(again["decoder"], list) and len(again["decoder"]) == 2
