"""Run by a Blender into which the zip was installed (in_blender.py): compress, preview, decode, write and read a mesh.

Argument: a folder for files. Lines that start with two spaces are for whoever reads the check.
"""
import importlib
import sys
import time
from pathlib import Path

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree

PACKAGE = "bl_ext.user_default.npm_blender"
folder = Path(sys.argv[sys.argv.index("--") + 1])


def positions(obj) -> np.ndarray:
    """Vertices of an object's mesh, (n, 3) float32."""
    V = np.zeros((len(obj.data.vertices), 3), dtype=np.float32)
    obj.data.vertices.foreach_get("co", V.reshape(-1))
    return V


def add_shape():
    """A bumpy closed surface of 20,480 faces, active."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=6, radius=1)
    obj = bpy.context.active_object
    V = positions(obj)
    V *= 1 + 0.2 * np.sin(5 * V[:, :1]) + 0.1 * np.sin(9 * V[:, 1:2] + 2 * V[:, 2:])
    obj.data.vertices.foreach_set("co", V.reshape(-1))
    obj.data.update()
    return obj


def check_packages(preferences) -> None:
    """In the worker: everything compiled comes from the zip's wheels."""
    bpy.ops.preferences.npmesh_check()
    found = dict(line.replace(":", "").split(" ", 1) for line in preferences.checked.splitlines())
    wheels = str(Path(bpy.utils.user_resource("EXTENSIONS"), ".local"))
    for name in ("numba", "trimesh", "pytetwild"):
        assert wheels in found[name], f"{name}: {found[name]}"
    assert wheels not in found["numpy"], "NumPy must be Blender's own"
    for name, text in found.items():
        print(f"  {name} {text.replace(wheels, 'the wheels')}")
    status = importlib.import_module(f"{PACKAGE}.runtime.packages").found()
    assert not [s.package.name for s in status if s.problem]


def main() -> None:
    """Everything that an artist does first."""
    assert PACKAGE in bpy.context.preferences.addons, "the extension is not enabled"
    assert "numba" not in sys.modules, "starting loads numba"
    preferences = bpy.context.preferences.addons[PACKAGE].preferences
    check_packages(preferences)

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=False)
    obj = add_shape()
    before, start = positions(obj), time.perf_counter()
    assert bpy.ops.object.npmesh_compress(base_faces=200, levels=3) == {"FINISHED"}
    took = time.perf_counter() - start
    shown = bpy.context.active_object
    state = shown.npmesh
    assert state.is_preview and obj.hide_get() and np.array_equal(positions(obj), before)
    print(f"  compressed 20,480 faces to {state.stream_bytes:,} bytes in {took:.1f} s")

    counts = []
    for level in range(state.level_count + 1):
        state.level = str(level)
        counts.append(len(shown.data.polygons))
    assert counts == [200 * 4**k for k in range(state.level_count + 1)], counts
    fine = positions(shown)
    state.features = 0
    none = positions(shown)
    state.features = state.total_features
    assert np.array_equal(positions(shown), fine) and not np.array_equal(none, fine)
    tree = BVHTree.FromPolygons(before.tolist(), [tuple(p.vertices) for p in obj.data.polygons])
    error = [float(np.mean([tree.find_nearest(v)[3] for v in V.tolist()])) for V in (none, fine)]
    assert error[1] < error[0] < 0.05, error
    print(f"  previewed levels of {', '.join(map(str, counts))} faces; mean distance to the original, of size 2.6: "
          f"{error[0]:.4f} with no features, {error[1]:.4f} with all {state.total_features}")

    path = folder / "shape.npmesh"
    assert bpy.ops.export_scene.npmesh(filepath=str(path)) == {"FINISHED"}
    assert bpy.ops.import_scene.npmesh(filepath=str(path)) == {"FINISHED"}
    opened = bpy.context.active_object
    opened.npmesh.level = str(opened.npmesh.level_count)
    assert opened != shown and np.array_equal(positions(opened), fine)
    path.with_name("cut.npmesh").write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    assert bpy.ops.import_scene.npmesh(filepath=str(folder / "cut.npmesh")) == {"FINISHED"}
    cut = bpy.context.active_object.npmesh
    assert 0 < cut.arrived_features < cut.total_features
    print(f"  wrote and opened {path.stat().st_size:,} bytes, and half of them with {cut.arrived_features} of "
          f"{cut.total_features} features")
    bpy.context.view_layer.objects.active = shown
    assert bpy.ops.object.npmesh_apply() == {"FINISHED"}
    assert ".local" in getattr(sys.modules.get("numba"), "__file__", ".local"), "numba is not the zip's"


main()
