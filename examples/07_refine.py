"""What is sent, improved by gradient descent through the decoder (npm_blender/core/refinement; needs torch).

The encoder makes a first guess. The sender can do better: it has the decoder and the input, so it moves base, latents and offsets
down the gradient of the distance between the two. The receiver pays nothing for it. Here 3 steps a stage; by default 24.
"""
import sys
from importlib.util import find_spec

from examples.picture import folder, plot
from examples.shapes import bumpy_torus
from npm_blender.core import CompressSettings, LodSettings, compress, open_stream, write_mesh
from npm_blender.core.evaluation import Original

if find_spec("torch") is None:
    print("torch is not installed, so there is nothing to refine with: pip install torch")
    sys.exit()

mesh = bumpy_torus(72, 28)
original, lines = Original(mesh, samples=10_000), {}
for steps in (0, 3):
    settings = CompressSettings(LodSettings(base_faces=100, levels=2), refine_steps=steps)
    stream = open_stream(compress(mesh, settings).data)
    counts = [n for n in (0, 20, 40, 100, 200, 400) if n < stream.features] + [stream.features]
    errors = [original.evaluate(stream.decode(features=n)).d_pm for n in counts]
    lines[f"{steps} steps a stage"] = [stream.bytes_for(n) for n in counts], errors
    print(f"{steps} steps a stage:", "  ".join(f"{n} features {error:.2f}" for n, error in zip(counts, errors)))
    write_mesh(folder() / f"07_after_{steps}_steps.ply", stream.decode(features=40))

plot(folder() / "07_refine.png", "bytes", "d_pm, 1e-4 of the longest side", lines)
