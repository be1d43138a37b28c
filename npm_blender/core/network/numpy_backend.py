"""The array namespace that the network is written against: NumPy here, torch in `torch_backend`.

Indexing, arithmetic, `@`, `.reshape` and `.T` are shared by both; the few calls that differ are methods. A parity
test holds the two together (1e-5 in the unit cube).
"""
import time
from collections.abc import Callable
from functools import cache

import numpy as np

CLEARLY = 0.7  # share of the usual product's time at which another one is taken


class NumpyBackend:
    """float32 NumPy: inference without torch. `index` arrays are int32 or int64."""

    name = "numpy"

    def array(self, x):
        """x as a float32 array of this backend."""
        return np.asarray(x, dtype=np.float32)

    def index(self, x):
        """x as an index array of this backend."""
        return np.asarray(x, dtype=np.int64)

    def take(self, x, index):
        """Rows of x: x[index]."""
        return np.take(x, index, axis=0)

    def product(self, x, w):
        """x (m, c) @ w (c, k)."""
        return fast_product()(x, w)

    def products(self, x, *ws):
        """x @ w for each of the matrices w (c, k_i): a list of (m, k_i)."""
        return [self.product(x, w) for w in ws]

    def dot(self, a, b):
        """Dot products of rows, (.., c) and (.., c) -> (..)."""
        return np.einsum("...c,...c->...", a, b)

    def permute(self, x, involution):
        """Rows of x, reordered by a permutation that is its own inverse (opposite half-edges)."""
        return np.take(x, involution, axis=0)

    def concat(self, parts, axis=1):
        """Concatenation along an axis."""
        return np.concatenate(parts, axis=axis)

    def split(self, x, widths):
        """x cut along axis 1 into parts of these widths."""
        return np.split(x, np.cumsum(widths)[:-1], axis=1)

    def turn(self, x, k):
        """x (m, 3, c) with slot s + k (mod 3) in the place of slot s."""
        return np.concatenate([x[:, k:], x[:, :k]], axis=1)

    def relu(self, x):
        """max(x, 0), element by element."""
        return np.maximum(x, 0)

    def log(self, x):
        """Natural logarithm."""
        return np.log(x)

    def arctan2(self, y, x):
        """Angle of (x, y) in radians."""
        return np.arctan2(y, x)

    def sqrt(self, x):
        """Square root."""
        return np.sqrt(x)

    def clamp(self, x, low):
        """max(x, low)."""
        return np.maximum(x, np.float32(low))

    def clip(self, x, bound):
        """x bounded to -bound..bound."""
        return np.clip(x, -np.float32(bound), np.float32(bound))

    def cross(self, a, b):
        """Cross products of rows (m, 3)."""
        return np.stack([a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1], a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2],
                         a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]], 1)

    def scatter_sum(self, x, index, n):
        """Sum of the rows of x (k, c) that share an index, (n, c)."""
        return np.stack([np.bincount(index, weights=column, minlength=n) for column in x.T], 1).astype(np.float32)

    def observe(self, layer, x):
        """Called with the input of every batch normalization; training updates the running statistics here."""


@cache
def fast_product() -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """The matrix product of this NumPy: np.matmul, unless it has no optimised BLAS.

    Debian builds its NumPy, and its Blender, on the reference BLAS; there einsum takes a quarter of the time. Asked by
    measuring, a few milliseconds once: what NumPy says of its build names a library that can be exchanged later.
    """
    x, w = np.ones((256, 128), np.float32), np.ones((128, 96), np.float32)

    def seconds(product) -> float:
        times = []
        for _ in range(3):
            start = time.perf_counter()
            product(x, w)
            times.append(time.perf_counter() - start)
        return min(times)

    return _einsum_product if seconds(_einsum_product) < CLEARLY * seconds(np.matmul) else np.matmul


def _einsum_product(x: np.ndarray, w: np.ndarray) -> np.ndarray:
    return np.einsum("ij,kj->ik", x, np.ascontiguousarray(w.T))  # dot products of contiguous rows: vectorised


NUMPY = NumpyBackend()
