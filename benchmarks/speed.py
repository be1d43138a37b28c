"""Seconds of each forward pass, medians of one run: `python -m benchmarks.speed [--threads N]`.

The mesh is a bumpy sphere of 81,920 faces made here, compressed to 400 faces and three levels without refinement.
Beside each figure stands the paper's for its CPU (section 4.6), and NumPy's share of torch's time where both exist.
"""

import argparse
import os
import statistics
import time


def median(function, repeats: int) -> float:
    """Median seconds of a call, after one that warms up."""
    function()
    seconds = []
    for _ in range(repeats):
        begun = time.perf_counter()
        function()
        seconds.append(time.perf_counter() - begun)
    return statistics.median(seconds)


def main() -> None:
    """Measure and print one table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--repeats", type=int, default=15)
    options = parser.parse_args()
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = str(options.threads)

    import torch

    from npm_blender.core import weights
    from npm_blender.core.backend import NUMPY
    from npm_blender.core.codec import compress, open_stream
    from npm_blender.core.decoder import decode
    from npm_blender.core.encoder import encode
    from npm_blender.core.network import map_tree
    from npm_blender.core.operators import MeshIndex
    from npm_blender.core.progressive import ProgressiveMesh
    from npm_blender.core.settings import CompressSettings
    from npm_blender.core.stream import read_stream
    from npm_blender.core.subdivide import hierarchy
    from npm_blender.core.torch_backend import TorchBackend
    from tests.shapes import bumpy

    torch.set_num_threads(options.threads)
    mesh = bumpy(6)
    data = compress(mesh, CompressSettings(refine_steps=0)).data
    stream = read_stream(data)
    opened = ProgressiveMesh(stream, len(data))
    levels = hierarchy(stream.F0, len(stream.V0), 3)
    params = weights.load().params
    positions = [opened.decode_positions(None, i).astype("float32") for i in range(4)]
    rows = []
    for B, tree in ((NUMPY, params), (TorchBackend(), map_tree(torch.from_numpy, params))):
        meshes = [MeshIndex.of(B, level) for level in levels]
        V = [B.array(v) for v in positions]
        with torch.no_grad():
            f = encode(B, tree, V, meshes)
            rows.append(
                (
                    B.name,
                    median(lambda b=B, t=tree, v=V, m=meshes: encode(b, t, v, m), options.repeats),
                    median(lambda b=B, t=tree, v=V, m=meshes, f=f: decode(b, t, v[0], f, m[:3]), options.repeats),
                )
            )
    print(f"{options.threads} thread(s), {len(levels[0].F)} -> {len(levels[3].F)} faces, stream of {len(data)} bytes")
    print("| backend | encode forward, ms (paper 7,420) | decode, ms (paper 6,930) |\n|---|---|---|")
    for name, encoding, decoding in rows:
        print(f"| {name} | {1000 * encoding:.1f} | {1000 * decoding:.1f} |")

    def slider():
        opened._cache.clear()
        opened.decode_positions(200, 3)

    for name, function in (
        ("open a stream", lambda: open_stream(data)),
        ("slider at level 3, new prefix", slider),
        ("slider at level 3, prefix seen before", lambda: opened.decode_positions(200, 3)),
    ):
        print(f"{name}: {1000 * median(function, options.repeats):.2f} ms")


if __name__ == "__main__":
    main()
