"""The torch side of the array namespace: training, refinement, and inference on a GPU."""
import torch


def torch_device(wanted: str) -> str:
    """torch's name of the device for 'cpu' or 'gpu' (ComputeSettings); 'cpu' where torch has no GPU that works."""
    if wanted == "gpu" and torch.cuda.is_available():
        return "cuda"  # ROCm's too
    if wanted == "gpu" and torch.backends.mps.is_available():
        return "mps"
    return "cpu"


class _Permute(torch.autograd.Function):
    """x[p] for an involution p: its gradient is again a gather, which is several times faster than a scatter."""

    @staticmethod
    def forward(ctx, x, p):
        ctx.p = p
        return x.index_select(0, p)

    @staticmethod
    def backward(ctx, g):
        return g.index_select(0, ctx.p), None


class TorchBackend:
    """float32 torch tensors on one device; see NumpyBackend for what the methods do."""

    name = "torch"

    def __init__(self, device: str = "cpu", momentum: float | None = None):
        """device: torch device; momentum: rate of the running statistics of batch normalization, None to leave them."""
        self.device = torch.device(device)
        self.momentum = momentum

    def array(self, x):
        return torch.as_tensor(x, dtype=torch.float32, device=self.device)

    def index(self, x):
        return torch.as_tensor(x, dtype=torch.int32, device=self.device)

    def numpy(self, x):
        """x as a NumPy array, without its gradient."""
        return x.detach().cpu().numpy()

    def take(self, x, index):
        return x.index_select(0, index)

    def product(self, x, w):
        return x @ w

    def products(self, x, *ws):
        return torch.split(x @ torch.cat(ws, dim=1), [w.shape[1] for w in ws], dim=1)

    def dot(self, a, b):
        return (a * b).sum(-1)

    def permute(self, x, involution):
        return _Permute.apply(x, involution)

    def concat(self, parts, axis=1):
        return torch.cat(parts, dim=axis)

    def split(self, x, widths):
        return torch.split(x, widths, dim=1)

    def turn(self, x, k):
        return torch.roll(x, -k, 1)

    def relu(self, x):
        return torch.relu(x)

    def log(self, x):
        return torch.log(x)

    def arctan2(self, y, x):
        return torch.arctan2(y, x)

    def sqrt(self, x):
        return torch.sqrt(x)

    def clamp(self, x, low):
        return torch.clamp(x, min=low)

    def clip(self, x, bound):
        return torch.clamp(x, -bound, bound)

    def cross(self, a, b):
        return torch.linalg.cross(a, b)

    def scatter_sum(self, x, index, n):
        return torch.zeros(n, x.shape[1], dtype=x.dtype, device=x.device).index_add(0, index, x)

    def observe(self, layer, x):
        if self.momentum and bool(torch.isfinite(x).all()):
            with torch.no_grad():
                layer["mean"].lerp_(x.mean(0), self.momentum)
                layer["var"].lerp_(x.var(0), self.momentum)
