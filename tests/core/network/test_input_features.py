import numpy as np
import pytest
import torch

from npm_blender.core.mesh.subdivision import Level
from npm_blender.core.network.frames import edge_frames
from npm_blender.core.network.input_features import CHANNELS, geometry_features
from npm_blender.core.network.mesh_index import MeshIndex
from npm_blender.core.network.numpy_backend import NUMPY
from npm_blender.core.network.torch_backend import TorchBackend
from tests.core.network.samples import SHAPES, rotated_corners
from tests.meshes.shapes import icosphere

TORCH = TorchBackend()


@pytest.mark.parametrize("name", SHAPES)
def test_they_do_not_depend_on_which_corner_comes_first(name):
    mesh = SHAPES[name]
    F, order = rotated_corners(mesh.F, np.random.default_rng(2).integers(0, 3, len(mesh.F)))
    one, two = Level.of(mesh.F, len(mesh.V)), Level.of(F, len(mesh.V))
    V = mesh.V.astype(np.float32)
    g, h = (geometry_features(NUMPY, V, MeshIndex.of(NUMPY, level)) for level in (one, two))
    assert np.allclose(g[order], h, atol=1e-5)


@pytest.mark.parametrize("name", SHAPES)
def test_geometry_features_do_not_change_under_motion_and_scale(name):
    mesh = SHAPES[name]
    index = MeshIndex.of(NUMPY, Level.of(mesh.F, len(mesh.V)))
    q, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    q *= np.sign(np.linalg.det(q))
    a = geometry_features(NUMPY, mesh.V.astype(np.float32), index)
    b = geometry_features(NUMPY, (2.5 * mesh.V @ q.T + 0.3).astype(np.float32), index)
    assert a.shape == (3 * len(mesh.F), CHANNELS)
    assert np.abs(a - b).max() < 2e-4


def test_degenerate_faces_have_finite_features_and_gradients():
    mesh = icosphere(1)
    V = mesh.V.copy()
    V[mesh.F[0]] = V[mesh.F[0, 0]]
    index = MeshIndex.of(TORCH, Level.of(mesh.F, len(V)))
    x = TORCH.array(V).requires_grad_(True)
    g = geometry_features(TORCH, x, index)
    frames = edge_frames(TORCH, x, index)
    (g.sum() + sum(f.sum() for f in frames)).backward()
    assert torch.isfinite(g).all() and torch.isfinite(x.grad).all()
