import numpy as np
import pytest

from npm_blender.core.mesh.subdivision import Level
from npm_blender.core.network.mesh_index import MeshIndex
from npm_blender.core.network.numpy_backend import NUMPY
from npm_blender.core.network.torch_backend import TorchBackend
from tests.core.network.samples import SHAPES


@pytest.mark.parametrize("name", SHAPES)
def test_edges_and_half_edges_name_the_same_vertices(name):
    mesh = SHAPES[name]
    level = Level.of(mesh.F, len(mesh.V))
    index = MeshIndex.of(NUMPY, level)
    inner = index.left != index.right  # the half-edge on the border may run either way
    assert np.array_equal(index.F[index.left][inner], index.edge_a[inner])
    assert np.array_equal(index.end[index.left][inner], index.edge_b[inner])
    assert np.array_equal(index.opposite[index.left], index.right)
    assert np.array_equal(index.edge_of[index.right], np.arange(len(level.edges)))
    assert np.array_equal(index.inner[:, 0] == 0, index.opposite == np.arange(3 * index.m))
    assert np.array_equal(index.side[index.left], np.ones((len(level.edges), 1)))
    assert np.allclose(np.bincount(index.F, index.share[index.F, 0]), 1)


def test_both_backends_hold_the_same_numbers():
    level = Level.of(SHAPES["open"].F, len(SHAPES["open"].V))
    B = TorchBackend()
    one, two = MeshIndex.of(NUMPY, level), MeshIndex.of(B, level)
    for name in set(MeshIndex.__dataclass_fields__) - {"m", "n"}:
        assert np.array_equal(getattr(one, name), B.numpy(getattr(two, name))), name
