"""A small corpus that Blender makes, for those who have none: `python -m benchmarks.made FOLDER`.

Six shapes of 2,000 to 21,000 faces: a face, a bust, a rock, a torus with bumps, a machined block with bores, a cloth
with a border. Blender runs in this process only, so that those that measure do not load it.
"""

import csv
import sys
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector, noise

from npm_blender.core.mesh import TriMesh
from npm_blender.core.meshio import write_mesh
from npm_blender.demo import sculpt

BUST_VOXEL = 0.062  # Blender units; the demo's sculpt at a third of its resolution


def _evaluated() -> TriMesh:
    """The active object with its modifiers, as triangles."""
    made = bpy.context.object.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    made.calc_loop_triangles()
    V = np.zeros(3 * len(made.vertices))
    made.vertices.foreach_get("co", V)
    F = np.zeros(3 * len(made.loop_triangles), np.int32)
    made.loop_triangles.foreach_get("vertices", F)
    return TriMesh.from_arrays(V.reshape(-1, 3), F.reshape(-1, 3))


def _bumped(mesh: TriMesh, height: float, scale: float) -> TriMesh:
    """Moved along the directions from the origin by fractal noise."""
    push = np.array([noise.fractal(Vector(p) * scale, 1.0, 2.0, 5) for p in mesh.V])
    return TriMesh(mesh.V * (1 + height * push[:, None]), mesh.F)


def face() -> TriMesh:
    """Suzanne, subdivided twice."""
    bpy.ops.mesh.primitive_monkey_add()
    bpy.context.object.modifiers.new("Smooth", "SUBSURF").levels = 2
    return _evaluated()


def bust() -> TriMesh:
    """The demo's sculpt, coarser."""
    before = sculpt.VOXEL
    sculpt.VOXEL = BUST_VOXEL
    try:
        return sculpt.make_sculpt()
    finally:
        sculpt.VOXEL = before


def rock() -> TriMesh:
    """A sphere under fractal noise."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=6)
    return _bumped(_evaluated(), 0.25, 1.3)


def ring() -> TriMesh:
    """A torus under fine noise."""
    bpy.ops.mesh.primitive_torus_add(major_segments=96, minor_segments=48, minor_radius=0.4)
    return _bumped(_evaluated(), 0.05, 4.0)


def block() -> TriMesh:
    """A block with rounded edges and two bores."""
    bpy.ops.mesh.primitive_cube_add()
    body = bpy.context.object
    bevel = body.modifiers.new("Round", "BEVEL")
    bevel.width, bevel.segments = 0.15, 6
    bores = []
    for radius, turn in ((0.5, (0, 0, 0)), (0.25, (np.pi / 2, 0, 0))):
        bpy.ops.mesh.primitive_cylinder_add(vertices=128, radius=radius, depth=4, rotation=turn)
        bores.append(bpy.context.object)
    for bore in bores:
        cut = body.modifiers.new("Bore", "BOOLEAN")
        cut.object, cut.operation, cut.solver = bore, "DIFFERENCE", "EXACT"
    bpy.context.view_layer.objects.active = body
    return _evaluated()


def cloth() -> TriMesh:
    """A square sheet in folds."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=80, y_subdivisions=80)
    mesh = _evaluated()
    fold = [noise.fractal(Vector((2 * x, 0.7 * y, 0)), 1.0, 2.0, 4) for x, y, _ in mesh.V]
    return TriMesh(mesh.V + np.outer(fold, (0, 0, 0.3)), mesh.F)


SHAPES: tuple[Callable[[], TriMesh], ...] = (face, bust, rock, ring, block, cloth)


def make(folder: Path) -> None:
    """Write all shapes and the manifest that lists them; the manifest last, so that a folder that has it is whole."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for shape in SHAPES:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        mesh = shape()
        write_mesh(folder / f"{shape.__name__}.ply", mesh)
        rows.append({"name": shape.__name__, "file": f"{shape.__name__}.ply", "split": "test", "faces": len(mesh.F)})
    with (folder / "manifest.csv").open("w", newline="") as out:
        writer = csv.DictWriter(out, rows[0])
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    make(Path(sys.argv[1]))
