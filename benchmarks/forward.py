"""Seconds of the forward passes of the paper's network, beside those that the publication names (its section 4.6)."""

from collections.abc import Callable
from contextlib import nullcontext

from npm_blender.core.bitstream import read_stream
from npm_blender.core.codec import ProgressiveMesh
from npm_blender.core.mesh import hierarchy
from npm_blender.core.network import NUMPY, MeshIndex, TorchBackend, decode, encode, load_weights, map_tree

PAPER = {"encode": 7.42, "decode": 6.93}  # seconds on a CPU


def passes(data: bytes) -> dict[tuple[str, str], Callable[[], object]]:
    """Calls by (backend, encode or decode), on the levels of a stream by the paper's model; torch where it is installed."""
    stream = read_stream(data)
    progressive = ProgressiveMesh(stream, len(data))
    levels = hierarchy(stream.F0, len(stream.grid), progressive.levels)
    params = load_weights().params
    positions = [progressive.decode_positions(None, i).astype("float32") for i in range(progressive.levels + 1)]
    backends, quiet = [(NUMPY, params)], nullcontext
    try:
        import torch
    except ImportError:
        pass
    else:
        torch.set_num_threads(1)
        quiet = torch.no_grad
        backends.append((TorchBackend(), map_tree(torch.from_numpy, params)))
    calls = {}
    for B, tree in backends:
        meshes, V = [MeshIndex.of(B, level) for level in levels], [B.array(v) for v in positions]
        with quiet():
            f = encode(B, tree, V, meshes)
        run = {"encode": lambda b=B, t=tree, v=V, m=meshes: encode(b, t, v, m),
               "decode": lambda b=B, t=tree, v=V, m=meshes, f=f: decode(b, t, v[0], f, m[:-1])}
        calls |= {(B.name, what): _under(quiet, call) for what, call in run.items()}
    return calls


def _under(context: Callable, call: Callable[[], object]) -> Callable[[], object]:
    def run() -> object:
        with context():
            return call()

    return run
