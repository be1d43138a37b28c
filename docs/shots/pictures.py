"""The pictures of docs/manual.md and the README, taken in a Blender with a window; see make.py."""
import os
import sys
from pathlib import Path

import bpy
from mathutils import Vector

sys.path.insert(0, str(Path(os.environ.get("NPM_ROOT", Path.cwd())) / "docs" / "shots"))

import window  # noqa: E402 - beside this file

FEATURES = 5000
APART = 2.7  # Blender units between two sculpts
BUDGETS = (1.0, 3.0, 12.5)  # kB; the last is all of it


def sideways(distance: float) -> Vector:
    """So far to the right on the screen."""
    return distance * (window.FRONT_RIGHT @ Vector((1, 0, 0)))


def panel_before_during_after() -> window.Picture:
    """The panel with an object that was not compressed yet, while it is compressed, and with its report."""
    obj = window.add_sculpt(compressed=False)
    window.frame([obj], 1.3)
    obj.npmesh.preset = "STANDARD"
    yield from window.drawn()
    window.save("before", "sidebar")
    obj.npmesh.preset = "DRAFT"  # seconds instead of minutes
    with window.in_viewport():
        bpy.ops.object.npmesh_compress("INVOKE_DEFAULT")
    jobs = window.module("jobs")
    yield from window.until(lambda: not jobs.running() or jobs.running()[0].fraction > 0.1)
    yield 0.2
    window.save("during", "sidebar")
    yield from window.until(lambda: bpy.context.view_layer.objects.active.npmesh.is_preview)
    obj.hide_set(False)  # the panel of the original has the report
    bpy.context.view_layer.objects.active.select_set(False)
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    yield from window.drawn()
    window.save("after", "sidebar")


def budgets() -> window.Picture:
    """What one sculpt shows after so many kilobytes."""
    window.add_sculpt(compressed=True)
    with window.in_viewport():
        bpy.ops.object.npmesh_preview()
    shown = bpy.context.view_layer.objects.active
    window.frame([shown], 1.7)
    for k, budget in enumerate(BUDGETS):
        shown.npmesh.budget = budget
        yield from window.drawn()
        window.save(f"budget{k}", "view")


def deviation() -> window.Picture:
    """The distance to the original as colours, with the legend in the panel."""
    shown = bpy.context.view_layer.objects.active
    shown.npmesh.budget = BUDGETS[1]
    shown.npmesh.show_deviation = True
    yield from window.until(lambda: shown.npmesh.deviation_top > 0 or shown.npmesh.deviation_problem)
    yield from window.drawn()
    window.save("deviation")
    shown.npmesh.show_deviation = False
    yield from window.drawn()


def lod_set() -> window.Picture:
    """All levels as objects of their own, side by side."""
    shown = bpy.context.view_layer.objects.active
    shown.npmesh.features = shown.npmesh.arrived_features
    before = set(bpy.data.objects)
    with window.in_viewport():
        bpy.ops.object.npmesh_lod_set(side_by_side=True)
    made = sorted(set(bpy.data.objects) - before, key=lambda obj: obj.name)
    for obj in before:
        obj.hide_set(True)
    viewport = window.viewport().spaces.active
    viewport.overlay.show_wireframes, viewport.show_region_ui = True, False
    window.frame(made, 1.0, 0.0, window.FRONT)
    yield from window.drawn()
    window.save("lod_set")
    viewport.overlay.show_wireframes, viewport.show_region_ui = False, True


def whole_window() -> window.Picture:
    """A sculpt and, beside it, the preview of its stream, with the sidebar that controls it."""
    obj = window.add_sculpt(compressed=True)
    with window.in_viewport():
        bpy.ops.object.npmesh_preview()
    shown = bpy.context.view_layer.objects.active
    shown.npmesh.features = FEATURES
    original = bpy.data.objects.new("Original", obj.data)
    bpy.context.collection.objects.link(original)
    shown.location += sideways(APART / 2)
    original.location -= sideways(APART / 2)
    window.frame([original, shown])
    yield from window.drawn()
    window.save("panel")


def batch() -> window.Picture:
    """Several objects in one job: the panel says which one it is."""
    window.clear()
    add = bpy.ops.mesh
    with window.in_viewport():
        for k, make in enumerate((add.primitive_monkey_add, add.primitive_torus_add, add.primitive_ico_sphere_add)):
            make(location=sideways(APART * (k - 1)))
            obj = bpy.context.active_object
            obj.modifiers.new("Finer", "SUBSURF").levels = 4
            bpy.ops.object.shade_smooth()
    for obj in bpy.context.view_layer.objects:
        obj.select_set(True)
    bpy.context.view_layer.objects.active.npmesh.preset = "DRAFT"
    window.frame(list(bpy.context.view_layer.objects))
    window.viewport().spaces.active.overlay.show_outline_selected = True
    yield from window.drawn()
    with window.in_viewport():
        bpy.ops.object.npmesh_compress("INVOKE_DEFAULT")
    jobs = window.module("jobs")
    job = jobs.running()[0]
    yield from window.until(lambda: job not in jobs.running() or (job.position == 1 and job.fraction > 0.4))
    yield 0.3
    window.save("batch")
    jobs.cancel_all()
    yield 0.5


window.take((panel_before_during_after, budgets, deviation, lod_set, whole_window, batch))
