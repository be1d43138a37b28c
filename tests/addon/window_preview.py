"""Checks of previews in a window: undo, the slider, saving, deleting, disabling; see run_in_window.py."""
import time
from pathlib import Path

import bpy

from .window_driver import (
    PACKAGE,
    TICK_SECONDS,
    active,
    compressed,
    fresh_object,
    in_viewport,
    say,
    shown,
    shown_is_decoded,
    start_compressing,
    until,
    until_idle,
)


def check_undo_and_redo():
    yield from compressed(5)
    obj = active()
    name = obj.name
    total = obj.npmesh.features
    for features, level in ((7, "2"), (total, "1"), (3, "0"), (20, "2")):
        obj.npmesh.features, obj.npmesh.level = features, level
        yield from shown()
        with in_viewport():
            bpy.ops.ed.undo_push(message="Slider")
    for features, level in ((3, "0"), (total, "1"), (7, "2"), (total, "2")):
        with in_viewport():
            bpy.ops.ed.undo()
        yield 0.2
        obj = bpy.data.objects[name]
        assert (obj.npmesh.features, obj.npmesh.level) == (features, level), "undo gives another state"
        shown_is_decoded(obj)
    with in_viewport():
        bpy.ops.ed.undo()
    yield 0.2
    assert name not in bpy.data.objects and not bpy.data.objects[0].hide_get(), "undo leaves the preview"
    for _ in range(5):
        with in_viewport():
            bpy.ops.ed.redo()
        yield 0.2
    obj = bpy.data.objects[name]
    assert (obj.npmesh.features, obj.npmesh.level) == (20, "2")
    shown_is_decoded(obj)


def check_dragging_the_slider():
    yield from compressed(5)
    obj = active()
    obj.npmesh.level = "2"
    took = []
    for k in range(40):
        start = time.perf_counter()
        obj.npmesh.detail = abs(20 - k) * 5
        took.append(time.perf_counter() - start)
        yield TICK_SECONDS
    yield from shown()
    shown_is_decoded(obj)
    took.sort()
    say(f"  setting the slider took {1000 * took[len(took) // 2]:.1f} ms, at most {1000 * took[-1]:.1f} ms")


def check_the_slider_draws_only_what_shows_it():
    yield from compressed(5)
    obj, drawn = active(), {"viewport": 0, "timeline": 0}

    def count(name):
        drawn[name] += 1

    watched = [(space, space.draw_handler_add(count, (name,), "WINDOW", "POST_PIXEL"))
               for space, name in ((bpy.types.SpaceView3D, "viewport"), (bpy.types.SpaceDopeSheetEditor, "timeline"))]
    for area in bpy.context.window_manager.windows[0].screen.areas:
        area.tag_redraw()
    yield from until(lambda: all(drawn.values()))  # both are there
    yield 0.5
    before = dict(drawn)
    for name, value in (("features", 3), ("detail", 60), ("budget", 0.5)):
        setattr(obj.npmesh, name, value)
        yield from shown()
    for space, handler in watched:
        space.draw_handler_remove(handler, "WINDOW")
    assert drawn["viewport"] >= before["viewport"] + 3 and drawn["timeline"] == before["timeline"], f"{before}, then {drawn}"


def check_a_size_limit_and_the_slider():
    obj = fresh_object(5)
    obj.npmesh.size_limit = 1.5
    start_compressing()
    yield from until_idle()
    obj = active()
    assert obj.npmesh.is_preview and 1200 < obj.npmesh.stream_bytes <= 1500
    for detail in (0, 35, 80, 100):
        obj.npmesh.detail = detail
        yield from shown()
        shown_is_decoded(obj)
    assert obj.npmesh.source.npmesh.size_limit == 1.5


def check_delete_and_discard():
    yield from compressed(5)
    obj = active()
    obj_name = obj.name
    with in_viewport():
        obj.npmesh.features = 2
        bpy.ops.ed.undo_push(message="Slider")
        bpy.ops.object.delete("EXEC_DEFAULT", True)  # True: with an undo step, as from the menu
        assert bpy.context.view_layer.objects.get(obj_name) is None
        bpy.ops.ed.undo()
    yield 0.3
    obj = next(o for o in bpy.data.objects if o.npmesh.is_preview)
    shown_is_decoded(obj)
    with in_viewport():
        bpy.context.view_layer.objects.active = obj
        bpy.ops.object.npmesh_discard()
    yield 0.3
    assert not any(o.npmesh.is_preview for o in bpy.data.objects)


def check_renaming_and_undo_after_deleting_the_original():
    yield from compressed(5)
    obj = active()
    obj.name, obj.data.name = "Other", "Another Mesh"
    obj.npmesh.features = 9
    yield from shown()
    shown_is_decoded(obj)
    with in_viewport():
        bpy.data.objects.remove(obj.npmesh.source)
        bpy.ops.ed.undo_push(message="Original deleted")
        obj.npmesh.show_original = True
    obj.npmesh.level = "1"
    yield from shown()
    shown_is_decoded(obj)
    with in_viewport():
        bpy.ops.object.npmesh_discard()
        bpy.ops.ed.undo_push(message="Discarded")
        bpy.ops.ed.undo()
    yield from shown()
    shown_is_decoded(bpy.data.objects["Other"])


def check_saving_and_opening_the_blend():
    yield from compressed(5)
    name = active().name
    active().npmesh.features, active().npmesh.level = 11, "1"
    yield 0.2
    path = str(Path(bpy.app.tempdir, "scene.blend"))
    with in_viewport():
        bpy.ops.wm.save_as_mainfile(filepath=path, check_existing=False)
        bpy.ops.wm.open_mainfile(filepath=path)
    yield from until(lambda: name in bpy.data.objects)
    obj = bpy.data.objects[name]
    assert (obj.npmesh.level, obj.npmesh.features) == ("1", 11)
    shown_is_decoded(obj)
    start = time.perf_counter()
    obj.npmesh.level = "2"
    took = time.perf_counter() - start
    yield from shown()
    shown_is_decoded(obj)
    say(f"  the first change after opening took {1000 * took:.0f} ms")


def check_appending_a_preview():
    yield from compressed(5)
    name = active().name
    path = str(Path(bpy.app.tempdir, "library.blend"))
    with in_viewport():
        bpy.ops.wm.save_as_mainfile(filepath=path, check_existing=False, copy=True)
        bpy.ops.wm.read_homefile(use_factory_startup=True)
    yield 1.0
    with in_viewport():
        bpy.ops.wm.append(directory=f"{path}/Object", filename=name)
    yield 0.5
    obj = bpy.data.objects[name]
    obj.npmesh.features, obj.npmesh.level = 5, "1"
    yield from shown()
    shown_is_decoded(obj)


def check_a_linked_preview_is_left_alone():
    path = str(Path(bpy.app.tempdir, "library.blend"))
    with in_viewport():
        bpy.ops.wm.read_homefile(use_factory_startup=True)
    yield 1.0
    with bpy.data.libraries.load(path, link=True) as (found, linked):
        linked.objects = [n for n in found.objects if n.endswith("Preview")]
    obj = linked.objects[0]
    bpy.context.collection.objects.link(obj)
    with in_viewport():
        bpy.ops.object.select_all(action="DESELECT")  # the cube could be compressed
        bpy.context.view_layer.objects.active = obj
        obj.select_set(True)
        assert not bpy.ops.object.npmesh_apply.poll() and not bpy.ops.object.npmesh_compress.poll()
        assert not bpy.ops.object.npmesh_discard.poll()
        bpy.ops.ed.undo_push(message="Linked")
        bpy.ops.ed.undo()
        bpy.ops.ed.redo()
    yield 0.5


def check_disabling_and_enabling_beside_a_preview():
    import addon_utils

    with in_viewport():
        bpy.ops.wm.read_homefile(use_factory_startup=True)
    yield 1.0
    yield from compressed(5)
    name = active().name
    addon_utils.disable(PACKAGE)
    yield 0.5
    with in_viewport():
        bpy.ops.ed.undo_push(message="Disabled")
        bpy.ops.ed.undo()
    addon_utils.enable(PACKAGE, default_set=True)
    yield 0.5
    obj = bpy.data.objects[name]
    assert obj.npmesh.is_preview
    obj.npmesh.features = 3
    yield from shown()
    shown_is_decoded(obj)
