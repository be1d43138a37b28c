"""Run by a Blender into which the zip was installed (in_blender.py): compress, preview, decode, write and read a mesh.

Arguments: a folder for files, and, to refine with it, a folder that holds torch. Lines that start with two spaces are
for whoever reads the check.
"""
import importlib
import sys
import time
from pathlib import Path

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree

PACKAGE = "bl_ext.user_default.npm_blender"
folder, *torch = map(Path, sys.argv[sys.argv.index("--") + 1:])


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
    """In the worker: everything compiled comes from the zip's wheels, and torch only from the folder that was chosen."""
    bpy.ops.preferences.npmesh_check()
    found = dict(line.replace(":", "").split(" ", 1) for line in preferences.checked.splitlines())
    wheels = str(Path(bpy.utils.user_resource("EXTENSIONS"), ".local"))
    for name in ("numba", "trimesh", "pytetwild"):
        assert wheels in found[name], f"{name}: {found[name]}"
    assert wheels not in found["numpy"], "NumPy must be Blender's own"
    assert (str(torch[0]) in found["torch"]) if torch else found["torch"] == "not found", found["torch"]
    for name, text in found.items():
        print(f"  {name} {text.replace(wheels, 'the wheels')}")
    status = importlib.import_module(f"{PACKAGE}.runtime.packages").found(preferences.torch_folder)
    assert [s.package.name for s in status if s.problem] == ([] if torch else ["torch"])
    if not torch:
        package = status[-1].package
        print(f"  torch is missing. {package.purpose}. Remedy: {package.remedy}")


def main() -> None:
    """Everything that an artist does first."""
    assert PACKAGE in bpy.context.preferences.addons, "the extension is not enabled"
    assert "torch" not in sys.modules and "numba" not in sys.modules, "starting loads torch or numba"
    preferences = bpy.context.preferences.addons[PACKAGE].preferences
    preferences.torch_folder = str(torch[0]) if torch else ""
    preferences.threads = 1 if torch else 0
    check_packages(preferences)

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=False)
    obj = add_shape()
    before, start = positions(obj), time.perf_counter()
    assert bpy.ops.object.npmesh_compress(base_faces=200, levels=2 if torch else 3, refine_steps=4) == {"FINISHED"}
    took = time.perf_counter() - start
    shown = bpy.context.active_object
    state = shown.npmesh
    assert state.is_preview and obj.hide_get() and np.array_equal(positions(obj), before)
    print(f"  compressed 20,480 faces to {state.stream_bytes:,} bytes in {took:.1f} s"
          f"{', refined with torch' if torch else ''}")
    notes = obj.npmesh.report.lower()
    assert ("not refined" in notes) != bool(torch), notes

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
    places = [m.__file__ for m in (sys.modules.get("numba"), sys.modules.get("torch")) if m]
    assert all(".local" in place for place in places), places


main()
