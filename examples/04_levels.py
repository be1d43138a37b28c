"""The levels M^0..M^L: points of the subdivided base on the input surface (npm_blender/core/levels).

The base is subdivided at the midpoints of its edges; the map of 03_map_points puts each new vertex on the input. The finest
level is then fitted: its vertices slide until the faces, not only the vertices, are near the input. The connectivity of a level
follows from the base alone, so a receiver needs positions only.
"""
from examples.picture import draw, folder
from examples.shapes import bumpy_torus
from npm_blender.core import TriMesh, evaluate, write_mesh
from npm_blender.core.decimation import decimate
from npm_blender.core.levels import build_levels
from npm_blender.core.mesh import hierarchy

mesh = bumpy_torus()
decimation = decimate(mesh, 100)  # build_lod does these two steps in one
lod = build_levels(decimation, 3)
sampled = build_levels(decimation, 3, fitted=False)

out, panels = folder(), {}
for number, level in enumerate(hierarchy(lod.F0, len(lod.V0), lod.level_count)):
    V = lod.V[: level.n] if number else lod.V0  # the vertices of a level are the first ones of the finest
    panels[f"M^{number}, {len(level.F):,} faces"] = TriMesh(V, level.F)
    error = evaluate(TriMesh(V, level.F), mesh, samples=20_000)
    before = evaluate(TriMesh(sampled.V[: level.n], level.F), mesh, samples=20_000)
    print(f"M^{number}: {len(level.F):5,} faces  d_pm {error.d_pm:6.2f}  d_normal {error.d_normal:5.2f} degrees"
          + (f"  (as the map puts them: {before.d_pm:6.2f}, {before.d_normal:5.2f})" if number else ""))
    write_mesh(out / f"04_level_{number}.ply", TriMesh(V, level.F))

draw(out / "04_levels.png", panels, edges=True)
