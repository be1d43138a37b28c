"""The paper's decoder: what a trained network makes of a base mesh, with and without features (npm_blender/core/network).

Midpoint subdivision alone adds faces and no shape. With zero features the network guesses how the surface runs between the
vertices; with the encoder's features, 8 numbers a face and level, it is told. That is what a file of model="paper" holds.
"""
import numpy as np

from examples.picture import draw, folder
from examples.shapes import bumpy_torus
from npm_blender.core import LodSettings, TriMesh, build_lod, evaluate, write_mesh
from npm_blender.core.mesh import hierarchy, midpoints
from npm_blender.core.network import FEATURES, NUMPY, MeshIndex, decode, encode, load_weights

mesh = bumpy_torus()
lod = build_lod(mesh, LodSettings(base_faces=200, levels=3))
levels = hierarchy(lod.F0, len(lod.V0), lod.level_count)
indices = [MeshIndex.of(NUMPY, level) for level in levels]  # the connectivity as the layers gather by it
params, V0 = load_weights().params, NUMPY.array(lod.V0)

zeros = [np.zeros((len(level.F), FEATURES), np.float32) for level in levels[:-1]]
latents = encode(NUMPY, params, [V0, *(NUMPY.array(lod.V[: level.n]) for level in levels[1:])], indices)
subdivided = [lod.V0]
for level in levels[:-1]:
    subdivided.append(midpoints(subdivided[-1], level))
shown = {"midpoint subdivision": subdivided[1:], "network, zero features": decode(NUMPY, params, V0, zeros, indices[:-1]),
         "network, encoder's features": decode(NUMPY, params, V0, latents, indices[:-1])}
for name, Vs in shown.items():
    errors = (evaluate(TriMesh(V, level.F), mesh, samples=20_000) for V, level in zip(Vs, levels[1:]))
    print(f"{name:28}", "  ".join(f"level {i}: d_pm {e.d_pm:5.2f}, {e.d_normal:4.1f} deg" for i, e in enumerate(errors, 1)))

panels = {name: TriMesh(np.asarray(Vs[-1], np.float64), levels[-1].F) for name, Vs in shown.items()}
write_mesh(folder() / "05_zero_features.ply", panels["network, zero features"])
draw(folder() / "05_network.png", {"base, 200 faces": TriMesh(lod.V0, lod.F0), **panels})
