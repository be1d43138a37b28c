"""The array operations that the network is written against: what NumPy's and torch's backends both fulfil.

Indexing, arithmetic, `@`, `.reshape`, `.sum` and `.mean` are the same in both libraries; the operations that differ are the
methods here.
"""
from collections.abc import Sequence
from typing import Any, Protocol, TypeAlias

import numpy as np

Array: TypeAlias = Any  # float32, an array of the backend in use; no type of Python's says "of NumPy or of torch, one of both"
Index: TypeAlias = Any  # whole numbers, for `take`, `permute` and `scatter_sum`; int64 in NumPy, int32 in torch
Layer: TypeAlias = dict[str, Array]  # the arrays of one layer, by name


class Backend(Protocol):
    """An array library, as encoder and decoder use it: `NUMPY` for inference, `TorchBackend` for gradients and GPUs.

    Functions of the network take one as their first argument `B`, and arrays of that library.

    >>> from npm_blender.core.network import NUMPY, Backend
    >>> def lengths(B: Backend, x):
    ...     return B.sqrt(B.dot(x, x))
    >>> lengths(NUMPY, NUMPY.array([[3, 4], [6, 8]])).tolist()
    [5.0, 10.0]
    """

    name: str

    def array(self, x: Any) -> Array:
        """x as a float32 array of this backend."""
        ...

    def index(self, x: Any) -> Index:
        """x as an index array of this backend."""
        ...

    def numpy(self, x: Any) -> np.ndarray:
        """An array or an index array as a NumPy array, without its gradient."""
        ...

    def take(self, x: Array, index: Index) -> Array:
        """Rows of x: x[index]."""
        ...

    def permute(self, x: Array, involution: Index) -> Array:
        """Rows of x, reordered by a permutation that is its own inverse (opposite half-edges)."""
        ...

    def scatter_sum(self, x: Array, index: Index, n: int) -> Array:
        """Sum of the rows of x (k, c) that share an index, (n, c)."""
        ...

    def concat(self, parts: Sequence[Array], axis: int = 1) -> Array:
        """Concatenation along an axis."""
        ...

    def split(self, x: Array, widths: Sequence[int]) -> Sequence[Array]:
        """x cut along axis 1 into parts of these widths."""
        ...

    def roll_slots(self, x: Array, k: int) -> Array:
        """x (m, 3, c) with slot s + k (mod 3) in the place of slot s."""
        ...

    def product(self, x: Array, w: Array) -> Array:
        """x (m, c) @ w (c, k)."""
        ...

    def products(self, x: Array, *ws: Array) -> Sequence[Array]:
        """x @ w for each of the matrices w (c, k_i): as many arrays (m, k_i)."""
        ...

    def dot(self, a: Array, b: Array) -> Array:
        """Dot products of rows, (.., c) and (.., c) -> (..)."""
        ...

    def cross(self, a: Array, b: Array) -> Array:
        """Cross products of rows (m, 3)."""
        ...

    def relu(self, x: Array) -> Array:
        """max(x, 0), element by element."""
        ...

    def log(self, x: Array) -> Array:
        """Natural logarithm."""
        ...

    def arctan2(self, y: Array, x: Array) -> Array:
        """Angle of (x, y) in radians."""
        ...

    def sqrt(self, x: Array) -> Array:
        """Square root."""
        ...

    def clamp(self, x: Array, low: float) -> Array:
        """max(x, low)."""
        ...

    def clip(self, x: Array, bound: float) -> Array:
        """x bounded to -bound..bound."""
        ...

    def observe(self, layer: Layer, x: Array) -> None:
        """Called with the input of every batch normalization: training updates the running statistics of `layer` here."""
        ...
