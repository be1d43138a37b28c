"""Edge collapses by quadric error, topology kept (npm_blender/core/decimation; Garland and Heckbert 1997).

The cheapest edge is collapsed first, where cheap means: the new vertex is near the planes of all faces that were collapsed into
it. A collapse that would change the topology, flip a face or make a sliver waits. The base keeps the hole of the torus.
"""
from examples.picture import draw, folder
from examples.shapes import bumpy_torus
from npm_blender.core import TriMesh, evaluate, write_mesh
from npm_blender.core.decimation import decimate
from npm_blender.core.mesh import topology_of

mesh = bumpy_torus()
out, panels = folder(), {f"input, {len(mesh.F):,} faces": mesh}
print(f"faces {len(mesh.F):6,}  Euler characteristic {topology_of(mesh.F).euler}")
for faces in (2000, 400, 100):
    decimation = decimate(mesh, faces)
    base = TriMesh(decimation.V0, decimation.F0)
    error = evaluate(base, mesh, samples=20_000)
    print(f"faces {len(base.F):6,}  Euler characteristic {topology_of(base.F).euler}  "
          f"d_pm {error.d_pm:6.2f}  d_reverse {error.d_reverse:6.2f}  (1e-4 of the longest side)")
    panels[f"{len(base.F)} faces"] = base
    write_mesh(out / f"02_base_{faces}.ply", base)

draw(out / "02_decimate.png", panels, edges=True)
