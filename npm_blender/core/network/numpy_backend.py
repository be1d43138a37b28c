"""The NumPy side of the backend: inference without torch. A parity test holds it to torch's (1e-5 in the unit cube)."""
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np

from .backend import Array, Backend, Index, Layer

REFERENCE_BLAS = ("blas", "cblas", "netlib")  # as NumPy names what it was built on


class NumpyBackend(Backend):
    """float32 NumPy; see `Backend` for what the methods do. `index` arrays are int64, and int32 does as well."""

    name = "numpy"

    def array(self, x: Any) -> Array:
        return np.asarray(x, dtype=np.float32)

    def index(self, x: Any) -> Index:
        return np.asarray(x, dtype=np.int64)

    def numpy(self, x: Any) -> np.ndarray:
        return np.asarray(x)

    def take(self, x: Array, index: Index) -> Array:
        return np.take(x, index, axis=0)

    def permute(self, x: Array, involution: Index) -> Array:
        return np.take(x, involution, axis=0)

    def scatter_sum(self, x: Array, index: Index, n: int) -> Array:
        return np.stack([np.bincount(index, weights=column, minlength=n) for column in x.T], 1).astype(np.float32)

    def concat(self, parts: Sequence[Array], axis: int = 1) -> Array:
        return np.concatenate(parts, axis=axis)

    def split(self, x: Array, widths: Sequence[int]) -> Sequence[Array]:
        return np.split(x, np.cumsum(widths)[:-1], axis=1)

    def roll_slots(self, x: Array, k: int) -> Array:
        return np.concatenate([x[:, k:], x[:, :k]], axis=1)

    def product(self, x: Array, w: Array) -> Array:
        return fast_product()(x, w)

    def products(self, x: Array, *ws: Array) -> Sequence[Array]:
        return [self.product(x, w) for w in ws]

    def dot(self, a: Array, b: Array) -> Array:
        return np.einsum("...c,...c->...", a, b)

    def cross(self, a: Array, b: Array) -> Array:
        return np.stack([a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1], a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2],
                         a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]], 1)

    def relu(self, x: Array) -> Array:
        return np.maximum(x, 0)

    def log(self, x: Array) -> Array:
        return np.log(x)

    def arctan2(self, y: Array, x: Array) -> Array:
        return np.arctan2(y, x)

    def sqrt(self, x: Array) -> Array:
        return np.sqrt(x)

    def clamp(self, x: Array, low: float) -> Array:
        return np.maximum(x, np.float32(low))

    def clip(self, x: Array, bound: float) -> Array:
        return np.clip(x, -np.float32(bound), np.float32(bound))

    def observe(self, layer: Layer, x: Array) -> None:
        pass  # nothing is trained here


@cache
def fast_product() -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """The matrix product of this NumPy: np.matmul, unless it was built on the reference BLAS.

    Debian builds its NumPy, and its Blender, so; there einsum takes a quarter of the time. The build decides and no timing does:
    both round in their own ways, and a choice that differs from run to run would give the same mesh other bytes.
    """
    try:
        show: Callable[..., Any] = np.show_config  # its stub tells of the printing form alone
        name = show(mode="dicts")["Build Dependencies"]["blas"]["name"]
    except (TypeError, KeyError):  # NumPy before 1.25 says it in another form
        name = ""
    return _einsum_product if name in REFERENCE_BLAS else np.matmul


def _einsum_product(x: np.ndarray, w: np.ndarray) -> np.ndarray:
    return np.einsum("ij,kj->ik", x, np.ascontiguousarray(w.T))  # dot products of contiguous rows: vectorised


NUMPY = NumpyBackend()
