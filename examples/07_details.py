"""What each stage of a stream adds (npm_blender/core/fitting finds the numbers, npm_blender/core/displacement moves by them).

A base is fitted so that the smooth surface over it is near the input. Then every vertex of every level is told how far it lies
off that surface, along its normal, first in coarse steps; each further stage halves the steps. A stop is the end of a stage.
"""
import numpy as np

from examples.picture import draw, folder, heat, plot
from examples.shapes import bumpy_torus
from npm_blender.core import CompressSettings, LodSettings, compress, open_stream, write_mesh
from npm_blender.core.evaluation import Original, thinned
from npm_blender.core.geometry import ClosestPoints

mesh = bumpy_torus(72, 28)
stream = open_stream(compress(mesh, CompressSettings(LodSettings(base_faces=100, levels=2))).data)
original, surface = Original(mesh, samples=10_000), ClosestPoints(mesh)

errors, panels, colours = [], {}, {}
shown, most = thinned(stream.stops, most=4), 0.01  # the longest side of the mesh is 1
for stop in stream.stops:
    decoded = stream.decode(stop)
    errors.append(original.evaluate(decoded).worse)
    print(f"{stop:6,} numbers, {stream.bytes_for(stop):6,} bytes: {errors[-1]:6.2f}")
    if stop in shown:
        title = f"{stop:,} numbers, {stream.bytes_for(stop):,} bytes"
        distance, _, _ = surface.closest(decoded.V[decoded.F].mean(1))  # of the centres of the faces
        panels[title], colours[title] = decoded, heat(np.minimum(distance / most, 1))
        write_mesh(folder() / f"07_with_{stop}_numbers.ply", decoded)

lines = {"the stops of the stream": ([stream.bytes_for(stop) for stop in stream.stops], errors)}
plot(folder() / "07_error_over_bytes.png", "bytes", "error the worse way, 1e-4 of the longest side", lines)
draw(folder() / "07_details.png", panels, colours)
