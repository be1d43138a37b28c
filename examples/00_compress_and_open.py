"""Arrays to bytes and back: the two functions that most people need (npm_blender/core/codec).

A stream holds a base mesh and then features, the coarsest first. Any prefix that holds the base opens: what is cut
off is detail, never surface.
"""
from examples.picture import draw, folder
from examples.shapes import bumpy_torus
from npm_blender.core import CompressSettings, LodSettings, compress, open_stream, write_mesh

mesh = bumpy_torus()
made = compress(mesh, CompressSettings(LodSettings(base_faces=200)))  # a small base for a small mesh
print(f"{len(mesh.F):,} faces -> {len(made.data):,} bytes; cleaning: {made.report.cleaning}")

stream = open_stream(made.data)
print(f"base mesh: {stream.base_faces} faces in {stream.base_bytes} bytes; levels 0 to {stream.levels}")

panels = {f"input, {len(mesh.F):,} faces": mesh}
for size in (stream.base_bytes, 1000, len(made.data)):
    cut = open_stream(made.data[:size])  # as if no more had arrived
    panels[f"{size:,} bytes, {cut.features:,} features"] = cut.decode()  # the finest level
    print(f"the first {size:,} bytes hold {cut.features:,} features")

out = folder()
(out / "00_torus.npmesh").write_bytes(made.data)
write_mesh(out / "00_decoded.ply", stream.decode())
draw(out / "00_compress_and_open.png", panels)
