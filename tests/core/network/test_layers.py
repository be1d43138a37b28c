import numpy as np
import pytest
import torch

from npm_blender.core.mesh.subdivision import Level
from npm_blender.core.network import layers, numpy_backend
from npm_blender.core.network.frames import edge_frames
from npm_blender.core.network.input_features import CHANNELS, geometry_features
from npm_blender.core.network.mesh_index import MeshIndex
from npm_blender.core.network.numpy_backend import NUMPY
from npm_blender.core.network.torch_backend import TorchBackend
from tests.meshes.shapes import grid, icosphere, torus

SHAPES = {"sphere": icosphere(1), "torus": torus(8, 6), "open": grid(4)}
TORCH = TorchBackend()


def layer(random, *widths, names=("own", "other")):
    rows, columns = widths
    return {**{n: random.normal(size=(3 * rows, columns)).astype(np.float32) for n in names},
            "bias": random.normal(size=columns).astype(np.float32)}


def turned(F, turns):
    """Faces with corner `turns` first, and the half-edges in their old numbering, in the new order."""
    k = (np.arange(3) + turns[:, None]) % 3
    return np.take_along_axis(F, k, 1), (3 * np.arange(len(F))[:, None] + k).reshape(-1)


@pytest.mark.parametrize("name", SHAPES)
def test_two_face_linear_is_what_it_says(name):
    random = np.random.default_rng(1)
    level = Level.of(SHAPES[name].F, len(SHAPES[name].V))
    x = random.normal(size=(3 * len(level.F), 4)).astype(np.float32)
    w = layer(random, 4, 5)
    y = layers.two_face_linear(NUMPY, x, level.opposite, w)
    for h in random.integers(0, len(x), 20):
        def seen(h):
            f, k = divmod(int(h), 3)
            return np.concatenate([x[3 * f + (k + s) % 3] for s in range(3)])
        expected = seen(h) @ w["own"] + seen(level.opposite[h]) @ w["other"] + w["bias"]
        assert np.allclose(y[h], expected, atol=1e-4)


@pytest.mark.parametrize("name", SHAPES)
def test_operators_do_not_depend_on_which_corner_comes_first(name):
    random = np.random.default_rng(2)
    mesh = SHAPES[name]
    F, order = turned(mesh.F, random.integers(0, 3, len(mesh.F)))
    one, two = Level.of(mesh.F, len(mesh.V)), Level.of(F, len(mesh.V))
    x = random.normal(size=(3 * len(F), 4)).astype(np.float32)
    w = layer(random, 4, 5)
    assert np.allclose(layers.two_face_linear(NUMPY, x, one.opposite, w)[order],
                       layers.two_face_linear(NUMPY, x[order], two.opposite, w), atol=1e-4)
    V = mesh.V.astype(np.float32)
    g, h = (geometry_features(NUMPY, V, MeshIndex.of(NUMPY, level)) for level in (one, two))
    assert np.allclose(g[order], h, atol=1e-5)
    up = layer(random, 4, 3, names=("corner0", "corner1", "corner2", "centre"))
    children = [layers.bilinear_upsample(NUMPY, a, level.opposite, up).reshape(-1, 4, 3, 3)
                for a, level in ((x, one), (x[order], two))]
    k = (order % 3).reshape(-1, 3)
    faces = np.arange(len(F))[:, None]
    assert np.allclose(children[0][:, :3][faces, k], children[1][:, :3], atol=1e-4)
    assert np.allclose(children[0][:, 3][faces, k], children[1][:, 3], atol=1e-4)


def test_upsampling_a_constant_without_weights_blends_to_the_constant():
    level = Level.of(SHAPES["torus"].F, len(SHAPES["torus"].V))
    one_slot = np.concatenate([np.eye(2), np.zeros((4, 2))]).astype(np.float32)
    up = {n: one_slot for n in ("corner0", "corner1", "corner2", "centre")}
    x = np.tile(np.array([[0.5, -2.0]], np.float32), (3 * len(level.F), 1))
    assert np.allclose(layers.bilinear_upsample(NUMPY, x, level.opposite, up), [0.5, -2.0])


def test_pooling_is_the_mean_of_the_children():
    pick = np.concatenate([np.eye(2), np.zeros((4, 2))]).astype(np.float32)
    pool = {n: pick for n in ("own", "next", "prev", "centre")}
    x = np.random.default_rng(0).normal(size=(12 * 5, 2)).astype(np.float32)
    children = x.reshape(5, 4, 3, 2)
    expected = (children[:, :3, 0].sum(1)[:, None] + children[:, 3]) / 4
    assert np.allclose(layers.average_pool(NUMPY, x, pool).reshape(5, 3, 2), expected, atol=1e-6)


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


@pytest.mark.parametrize("name", SHAPES)
def test_edge_frames_are_orthonormal(name):
    mesh = SHAPES[name]
    index = MeshIndex.of(NUMPY, Level.of(mesh.F, len(mesh.V)))
    x, y, z, length = edge_frames(NUMPY, mesh.V.astype(np.float32), index)
    frame = np.stack([x, y, z], 1)
    assert np.allclose(frame @ frame.transpose(0, 2, 1), np.eye(3), atol=1e-5)
    assert (np.linalg.det(frame) > 0.99).all() and (length > 0).all()


@pytest.mark.parametrize("shape", [(400, 30, 96), (1, 8, 6), (1600, 96, 48)])
def test_the_product_of_a_numpy_without_blas_is_the_same(shape):
    rng = np.random.default_rng(3)
    x, w = (rng.standard_normal(size).astype(np.float32) for size in (shape[:2], shape[1:]))
    found = numpy_backend._einsum_product(x, w)
    assert found.dtype == np.float32 and found.flags.c_contiguous
    assert np.allclose(found, x.astype(np.float64) @ w, atol=1e-4)
