"""The torch side of the backend: training, and inference on a GPU."""
from collections.abc import Sequence
from typing import Any

import numpy as np
import torch

from .backend import Array, Backend, Index, Layer


def torch_device(wanted: str) -> str:
    """torch's name of the device for 'cpu' or 'gpu' (ComputeSettings); 'cpu' where torch has no GPU that works.

    >>> from npm_blender.core.network import torch_device
    >>> torch_device("cpu")
    'cpu'
    """
    if wanted == "gpu" and torch.cuda.is_available():
        return "cuda"  # ROCm's too
    if wanted == "gpu" and torch.backends.mps.is_available():
        return "mps"
    return "cpu"


class _Permute(torch.autograd.Function):
    """x[p] for an involution p: its gradient is again a gather, which is several times faster than a scatter."""

    @staticmethod
    def forward(ctx: Any, x: Array, p: Index) -> Array:
        ctx.p = p
        return x.index_select(0, p)

    @staticmethod
    def backward(ctx: Any, g: Array) -> tuple[Array, None]:
        return g.index_select(0, ctx.p), None


class TorchBackend(Backend):
    """float32 torch tensors on one device; see `Backend` for what the methods do.

    >>> from npm_blender.core.network import TorchBackend
    >>> B = TorchBackend("cpu")
    >>> x = B.array([[1.0, 2.0], [3.0, 4.0]]).requires_grad_(True)
    >>> B.dot(x, x).sum().backward()
    >>> B.numpy(x.grad).tolist()
    [[2.0, 4.0], [6.0, 8.0]]
    """

    name = "torch"

    def __init__(self, device: str = "cpu", momentum: float | None = None):
        """device: torch device; momentum: rate of the running statistics of batch normalization, None to leave them."""
        self.device = torch.device(device)
        self.momentum = momentum

    def array(self, x: Any) -> Array:
        return torch.as_tensor(x, dtype=torch.float32, device=self.device)

    def index(self, x: Any) -> Index:
        return torch.as_tensor(x, dtype=torch.int32, device=self.device)

    def numpy(self, x: Any) -> np.ndarray:
        return x.detach().cpu().numpy()

    def take(self, x: Array, index: Index) -> Array:
        return x.index_select(0, index)

    def permute(self, x: Array, involution: Index) -> Array:
        return _Permute.apply(x, involution)

    def scatter_sum(self, x: Array, index: Index, n: int) -> Array:
        return torch.zeros(n, x.shape[1], dtype=x.dtype, device=x.device).index_add(0, index, x)

    def concat(self, parts: Sequence[Array], axis: int = 1) -> Array:
        return torch.cat(parts, dim=axis)

    def split(self, x: Array, widths: Sequence[int]) -> Sequence[Array]:
        return torch.split(x, widths, dim=1)

    def roll_slots(self, x: Array, k: int) -> Array:
        return torch.roll(x, -k, 1)

    def product(self, x: Array, w: Array) -> Array:
        return x @ w

    def products(self, x: Array, *ws: Array) -> Sequence[Array]:
        return torch.split(x @ torch.cat(ws, dim=1), [w.shape[1] for w in ws], dim=1)

    def dot(self, a: Array, b: Array) -> Array:
        return (a * b).sum(-1)

    def cross(self, a: Array, b: Array) -> Array:
        return torch.linalg.cross(a, b)

    def relu(self, x: Array) -> Array:
        return torch.relu(x)

    def log(self, x: Array) -> Array:
        return torch.log(x)

    def arctan2(self, y: Array, x: Array) -> Array:
        return torch.arctan2(y, x)

    def sqrt(self, x: Array) -> Array:
        return torch.sqrt(x)

    def clamp(self, x: Array, low: float) -> Array:
        return torch.clamp(x, min=low)

    def clip(self, x: Array, bound: float) -> Array:
        return torch.clamp(x, -bound, bound)

    def observe(self, layer: Layer, x: Array) -> None:
        if self.momentum and bool(torch.isfinite(x).all()):
            with torch.no_grad():
                layer["mean"].lerp_(x.mean(0), self.momentum)
                layer["var"].lerp_(x.var(0), self.momentum)
