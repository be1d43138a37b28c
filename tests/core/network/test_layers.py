import numpy as np
import pytest

from npm_blender.core.mesh.subdivision import Level
from npm_blender.core.network import layers
from npm_blender.core.network.numpy_backend import NUMPY
from tests.core.network.samples import SHAPES, layer, rotated_corners


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
def test_layers_do_not_depend_on_which_corner_comes_first(name):
    random = np.random.default_rng(2)
    mesh = SHAPES[name]
    F, order = rotated_corners(mesh.F, random.integers(0, 3, len(mesh.F)))
    one, two = Level.of(mesh.F, len(mesh.V)), Level.of(F, len(mesh.V))
    x = random.normal(size=(3 * len(F), 4)).astype(np.float32)
    w = layer(random, 4, 5)
    assert np.allclose(layers.two_face_linear(NUMPY, x, one.opposite, w)[order],
                       layers.two_face_linear(NUMPY, x[order], two.opposite, w), atol=1e-4)
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
