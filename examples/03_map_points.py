"""The bijection that edge collapses define (npm_blender/core/parameterization).

It is successive self-parameterization (Liu et al. 2020): every collapse flattens its few faces, before and after, onto the same
piece of the plane. Composed, the flattenings take each point of the base to one point of the input and back. A point is a
face and three barycentric coordinates.
"""
import numpy as np

from examples.picture import draw, folder
from examples.shapes import bumpy_torus
from npm_blender.core import TriMesh, write_mesh
from npm_blender.core.decimation import decimate

mesh = bumpy_torus()
decimation = decimate(mesh, 120)
base, between = TriMesh(decimation.V0, decimation.F0), decimation.surface_map

# from the input to the base: the centres of all faces, each of which takes the colour of the base face that it ends up on
thirds = np.full((len(mesh.F), 3), 1 / 3)
on_base, there = between.fine_to_coarse(np.arange(len(mesh.F)), thirds)
colour = np.random.default_rng(4).uniform(0.35, 1, (len(base.F), 3))
face, back = between.coarse_to_fine(on_base, there)
off = np.linalg.norm((mesh.V[mesh.F[face]] * back[:, :, None]).sum(1) - mesh.V[mesh.F].mean(1), axis=1)
print(f"there and back again: {len(off):,} points, the farthest is {off.max():.1e} from where it began")

# from the base to the input: points along the edges of the base, which become curves on the input
share = np.linspace(0, 1, 60)
face, share = np.repeat(np.arange(len(base.F)), len(share)), np.tile(share, len(base.F))
b = np.stack([1 - share, share, 0 * share], 1)
on_input, b_input = between.coarse_to_fine(face, b)
curves = {"base": (base.V[base.F[face]] * b[:, :, None]).sum(1), "input": (mesh.V[mesh.F[on_input]] * b_input[:, :, None]).sum(1)}

write_mesh(folder() / "03_base.ply", base)
draw(folder() / "03_map_points.png", {"base": base, "input": mesh}, {"base": colour, "input": colour[on_base]}, curves)
