"""What a prefix is worth: error over bytes (npm_blender/core/bitstream codes the numbers, npm_blender/core/codec stages them).

Numbers are sent in coarse steps first, so the error falls fast at first. The stream is cut at ever later bytes and opened.
"""
import numpy as np

from examples.picture import draw, folder, plot
from examples.shapes import bumpy_torus
from npm_blender.core import CompressSettings, LodSettings, compress, open_stream, write_mesh
from npm_blender.core.evaluation import Original

mesh = bumpy_torus()
data = compress(mesh, CompressSettings(LodSettings(base_faces=200))).data
whole, original = open_stream(data), Original(mesh, samples=10_000)

sizes, errors, panels = np.geomspace(whole.base_bytes, len(data), 7).round().astype(int), [], {}
for size in sizes.tolist():
    cut = open_stream(data[:size])
    decoded = cut.decode()
    errors.append(original.evaluate(decoded))
    panels[f"{size:,} bytes"] = decoded
    print(f"{size:6,} bytes  {cut.features:5,} features  error {errors[-1].worse:6.2f}  d_normal {errors[-1].d_normal:5.2f}")

out = folder()
write_mesh(out / "06_half.ply", open_stream(data[: len(data) // 2]).decode())
lines = {"the stream, cut": (sizes, [error.worse for error in errors])}
plot(out / "06_error_over_bytes.png", "bytes", "error the worse way, 1e-4 of the longest side", lines)
draw(out / "06_prefixes.png", {title: panels[title] for title in list(panels)[::2][:4]})
