"""Any triangles in, an oriented manifold out (npm_blender/core/cleaning).

A mesh from the wild: faces that are flipped, faces that are there twice, a seam where vertices are doubled, a fin on an edge.
Each step of the cleaning says in one phrase what it did. Faces seen from behind are red.
"""
import numpy as np

from examples.picture import draw, folder
from examples.shapes import bumpy_torus
from npm_blender.core import TriMesh, write_mesh
from npm_blender.core.cleaning import clean, inspect

mesh = bumpy_torus(72, 28)
V, F = mesh.V, mesh.F.copy()
centre = V[F].mean(1)
flipped = (centre[:, 0] > 0.05) & (centre[:, 1] > 0.1)
F[flipped] = F[flipped, ::-1]  # their corners run clockwise, seen from outside
F = np.concatenate([F, F[1000:1040]])  # these faces are there twice
seam = np.arange(28)  # the first ring round the tube gets a copy of each vertex, for the faces on one side of it
on_one_side = (F >= 71 * 28).any(1)
F[on_one_side] = np.where(np.isin(F, seam), F + len(V), F)[on_one_side]
V = np.concatenate([V, V[seam]])
F = np.concatenate([F, [[628, 600, len(V)]]])  # a fin: a third face on an edge that has two
broken = TriMesh.from_arrays(np.concatenate([V, [V[600] * 1.15 + [0, 0, 0.06]]]), F)

print("found:  ", ", ".join(inspect(broken).problems))
cleaned, report = clean(broken)
print("changed:", "; ".join(report.changes))
print("left:   ", "; ".join(report.notes) or "nothing to note")
print("now:    ", ", ".join(inspect(cleaned).problems) or "an oriented manifold")

out = folder()
write_mesh(out / "01_broken.ply", broken)
write_mesh(out / "01_cleaned.ply", cleaned)
draw(out / "01_clean.png", {"as it came": broken, "cleaned": cleaned})
