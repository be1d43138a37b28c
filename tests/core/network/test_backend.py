"""Both backends have the methods of the protocol, with its signatures, and give the same numbers."""
import inspect

import numpy as np
import pytest

from npm_blender.core.network import numpy_backend
from npm_blender.core.network.backend import Backend
from npm_blender.core.network.numpy_backend import NUMPY, NumpyBackend
from npm_blender.core.network.torch_backend import TorchBackend

TORCH = TorchBackend()
RNG = np.random.default_rng(0)
ROWS, COLUMNS = RNG.normal(size=(6, 3)).astype(np.float32), RNG.normal(size=(3, 4)).astype(np.float32)
SWAP = [1, 0, 2, 4, 3, 5]
CALLS = {  # every method, on arrays of the backend
    "array": lambda B, x, w: B.array([[1, 2]]),
    "index": lambda B, x, w: B.index(SWAP),
    "numpy": lambda B, x, w: B.numpy(x),
    "take": lambda B, x, w: B.take(x, B.index([5, 0, 5])),
    "permute": lambda B, x, w: B.permute(x, B.index(SWAP)),
    "scatter_sum": lambda B, x, w: B.scatter_sum(x, B.index([0, 2, 2, 0, 3, 3]), 5),
    "concat": lambda B, x, w: B.concat([x, x, x[:, :1]]),
    "split": lambda B, x, w: B.split(x, [1, 2])[1],
    "roll_slots": lambda B, x, w: B.roll_slots(x.reshape(2, 3, 3), 2),
    "product": lambda B, x, w: B.product(x, w),
    "products": lambda B, x, w: B.products(x, w, w[:, :2])[1],
    "dot": lambda B, x, w: B.dot(x, 2 * x),
    "cross": lambda B, x, w: B.cross(x, B.permute(x, B.index(SWAP))),
    "relu": lambda B, x, w: B.relu(x),
    "log": lambda B, x, w: B.log(x * x),
    "arctan2": lambda B, x, w: B.arctan2(x, x - 1),
    "sqrt": lambda B, x, w: B.sqrt(x * x),
    "clamp": lambda B, x, w: B.clamp(x, 0.1),
    "clip": lambda B, x, w: B.clip(x, 0.5),
}


def methods(of: type) -> dict[str, inspect.Signature]:
    """Public methods that a class itself has, with their signatures."""
    return {name: inspect.signature(value) for name, value in vars(of).items()
            if inspect.isfunction(value) and not name.startswith("_")}


@pytest.mark.parametrize("backend", [NumpyBackend, TorchBackend])
def test_a_backend_has_exactly_the_methods_of_the_protocol(backend):
    assert methods(backend) == methods(Backend)
    assert isinstance(backend.name, str)


def test_every_method_of_the_protocol_says_what_it_does():
    assert all(getattr(Backend, name).__doc__ for name in methods(Backend))


@pytest.mark.parametrize("name", sorted(methods(Backend).keys() - {"observe"}))
def test_both_give_the_same_numbers(name):
    found = [B.numpy(CALLS[name](B, B.array(ROWS), B.array(COLUMNS))) if name != "numpy" else
             CALLS[name](B, B.array(ROWS), None) for B in (NUMPY, TORCH)]
    assert found[0].shape == found[1].shape
    assert np.allclose(found[0], found[1], atol=1e-6)


def test_running_statistics_move_in_training_only():
    layer = {"mean": TORCH.array(np.zeros(3)), "var": TORCH.array(np.ones(3))}
    NUMPY.observe(layer, ROWS)
    TORCH.observe(layer, TORCH.array(ROWS))
    assert not TORCH.numpy(layer["mean"]).any()
    TorchBackend(momentum=0.5).observe(layer, TORCH.array(ROWS))
    assert np.allclose(TORCH.numpy(layer["mean"]), ROWS.mean(0) / 2, atol=1e-6)


@pytest.mark.parametrize("shape", [(400, 30, 96), (1, 8, 6), (1600, 96, 48)])
def test_the_product_of_a_numpy_without_blas_is_the_same(shape):
    rng = np.random.default_rng(3)
    x, w = (rng.standard_normal(size).astype(np.float32) for size in (shape[:2], shape[1:]))
    found = numpy_backend._einsum_product(x, w)
    assert found.dtype == np.float32 and found.flags.c_contiguous
    assert np.allclose(found, x.astype(np.float64) @ w, atol=1e-4)
