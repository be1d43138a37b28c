"""How far a decoded mesh is from its source (npm_blender/core/evaluation): its numbers, and a picture of where.

d_pm: mean distance from the decoded surface to the source; d_reverse: the other way, which shows what the decoded mesh misses;
worse: the larger of both, by which files are compared;
d_p99: the distance that 99 of 100 points stay within, all in 1e-4 of the longest side; d_normal: mean angle of normals.
"""
import numpy as np

from examples.picture import draw, folder, heat
from examples.shapes import bumpy_torus
from npm_blender.core import CompressSettings, LodSettings, compress, evaluate, open_stream, write_mesh
from npm_blender.core.evaluation import thinned
from npm_blender.core.geometry import ClosestPoints

mesh = bumpy_torus()
stream = open_stream(compress(mesh, CompressSettings(LodSettings(base_faces=200))).data)
surface, most = ClosestPoints(mesh), 0.006  # the longest side of the mesh is 1

panels, colours = {}, {}
for features in thinned(stream.stops, most=3):
    decoded = stream.decode(features)
    e = evaluate(decoded, mesh, samples=20_000)
    print(f"{features:6,} features  d_pm {e.d_pm:6.2f}  d_reverse {e.d_reverse:6.2f}  d_p99 {e.d_p99:6.2f}  "
          f"d_normal {e.d_normal:5.2f}")
    distance, _, _ = surface.closest(decoded.V[decoded.F].mean(1))  # of the centres of the faces
    title = f"{features:,} features: 0 (blue) to {100 * most:.1f} % (red)"
    panels[title], colours[title] = decoded, heat(np.minimum(distance / most, 1))
    write_mesh(folder() / f"08_with_{features}_features.ply", decoded)

draw(folder() / "08_evaluate.png", panels, colours)
