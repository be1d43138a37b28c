"""Checks in a window of what is done with a preview: deviation, playing, LOD sets, linked files; see run_in_window.py."""
import shutil
import sys
from pathlib import Path

import bpy

from .window_driver import (
    STALL_SECONDS,
    active,
    busy,
    compressed,
    gaps,
    in_viewport,
    module,
    redraw_stall,
    say,
    shown,
    shown_is_decoded,
    until,
)


def set_by_user(message: str, **properties) -> None:
    """Set properties of the active preview with an undo step, as the panel does."""
    for name, value in properties.items():
        setattr(active().npmesh, name, value)
    with in_viewport():
        bpy.ops.ed.undo_push(message=message)


def colour_types() -> set[str]:
    return {area.spaces.active.shading.color_type for area in bpy.context.screen.areas if area.type == "VIEW_3D"}


def undo() -> None:
    with in_viewport():
        bpy.ops.ed.undo()


def redo() -> None:
    with in_viewport():
        bpy.ops.ed.redo()


def check_deviation_keeps_the_window_alive():
    yield from compressed(8)  # 327,680 faces
    busy.clear()
    redraw = yield from redraw_stall()
    drawing = max(busy)
    gaps.clear()
    busy.clear()
    active().npmesh.show_deviation = True
    yield from until(lambda: not module("preview").is_busy())
    first, first_busy = max(gaps), max(busy)
    state = active().npmesh
    assert state.deviation_problem == "" and state.deviation_mean > 0, "nothing was measured"
    gaps.clear()
    busy.clear()
    state.features = 12
    yield from until(lambda: not module("preview").is_busy())
    say(f"  an original of 327,680 faces, longest stalls in ms, and of the window's own thread: first colours "
        f"{1000 * first:.0f}, {1000 * first_busy:.0f}; of another stop {1000 * max(gaps):.0f}, {1000 * max(busy):.0f}; "
        f"drawing alone {1000 * redraw:.0f}, {1000 * drawing:.0f}")
    assert max(first_busy, max(busy)) - drawing <= STALL_SECONDS, "the window stands still for too long"
    assert active().data["npmesh_deviation"].startswith(active().data["npmesh_shown"])


def check_undo_of_the_deviation():
    yield from compressed(5)
    name = active().name
    before = colour_types()
    set_by_user("Deviation", show_deviation=True)
    yield from shown()
    assert colour_types() == {"VERTEX"} and "Deviation" in active().data.color_attributes
    set_by_user("Slider", features=4)
    yield from shown()
    undo()
    yield from shown()
    obj = bpy.data.objects[name]
    assert obj.npmesh.show_deviation and colour_types() == {"VERTEX"}
    assert obj.data["npmesh_deviation"].startswith(obj.data["npmesh_shown"])
    undo()
    yield 0.3
    assert not bpy.data.objects[name].npmesh.show_deviation and colour_types() == before
    redo()
    yield from shown()
    assert colour_types() == {"VERTEX"}
    with in_viewport():
        bpy.ops.object.delete("EXEC_DEFAULT", True)
    yield 2.0
    assert colour_types() == before, "deleting the preview leaves the viewport"


def check_playing():
    yield from compressed(5)
    state, playback = active().npmesh, module("preview.playback")
    total = state.features
    state.play_rate = 8 * state.shown_bytes / 12 / 1000  # twelve seconds, of which a busy machine shows some
    yield from shown()
    with in_viewport():
        assert bpy.ops.object.npmesh_play("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    seen = []
    while playback.is_playing(active()):
        seen.append(state.features)
        yield 0.05
    yield from shown()
    assert seen == sorted(seen) and seen[0] == 0 and len(set(seen)) > 2, seen
    assert state.features == total
    shown_is_decoded(active())
    state.play_rate /= 30
    with in_viewport():
        bpy.ops.ed.undo_push(message="Slower")
        bpy.ops.ed.undo_push(message="Something Else")
    for end in (bpy.ops.object.npmesh_stop_playing, undo, lambda: bpy.data.objects.remove(active())):
        obj = next(o for o in bpy.data.objects if o.npmesh.is_preview)
        bpy.context.view_layer.objects.active = obj
        with in_viewport():
            bpy.ops.object.npmesh_play("INVOKE_DEFAULT")
        yield 0.3
        assert playback.is_playing(obj)
        with in_viewport():
            end()
        yield 0.5
        assert not playback._plays, "playing goes on"


def check_a_lod_set_is_one_step():
    yield from compressed(5)
    before = set(bpy.data.objects.keys())
    with in_viewport():
        bpy.ops.object.npmesh_lod_set("EXEC_DEFAULT", True, convention="UNREAL")
    made = set(bpy.data.objects.keys()) - before
    assert len(made) == 4, made
    undo()
    yield 0.3
    assert set(bpy.data.objects.keys()) == before and not any("LOD" in c.name for c in bpy.data.collections)
    redo()
    yield 0.3
    assert set(bpy.data.objects.keys()) == before | made


def check_beside_is_undone():
    yield from compressed(5)
    name, source = active().name, active().npmesh.source.name
    with in_viewport():
        active().npmesh.beside = True
        bpy.ops.ed.undo_push(message="Beside")
    assert active().location.x > 1 and not bpy.data.objects[source].hide_get()
    undo()
    yield 0.3
    assert bpy.data.objects[name].location.x == 0 and bpy.data.objects[source].hide_get()
    redo()
    yield 0.3
    assert bpy.data.objects[name].location.x > 1 and not bpy.data.objects[source].hide_get()


def check_apply_and_discard_are_undone():
    yield from compressed(5)
    name = active().name
    set_by_user("Slider", features=9, level="1")
    yield from shown()
    with in_viewport():
        bpy.ops.object.npmesh_apply("EXEC_DEFAULT", True)
    assert not bpy.data.objects[name].npmesh.is_preview
    undo()
    yield from shown()
    shown_is_decoded(bpy.data.objects[name])
    with in_viewport():
        bpy.ops.object.npmesh_discard("EXEC_DEFAULT", True)
    assert name not in bpy.data.objects
    undo()
    yield from shown()
    shown_is_decoded(bpy.data.objects[name])
    assert bpy.data.objects[name].npmesh.features == 9


def check_a_linked_file():
    yield from compressed(5)
    name = active().name
    folder = Path(bpy.app.tempdir, "linked")
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    stream = active()["npmesh_stream"]
    blend = str(folder / "scene.blend")
    with in_viewport():
        bpy.ops.wm.save_as_mainfile(filepath=blend, check_existing=False)
        bpy.ops.object.npmesh_link("EXEC_DEFAULT", filepath=str(folder / "shape.npmesh"))
        bpy.ops.wm.save_mainfile()
        bpy.ops.wm.open_mainfile(filepath=blend)
    yield from until(lambda: name in bpy.data.objects)
    yield from until(lambda: not module("preview.linked")._reading)
    obj = bpy.data.objects[name]
    gaps.clear()
    obj.npmesh.features = 7
    yield from shown()
    say(f"  the longest stall of the first slider move after opening was {1000 * max(gaps):.0f} ms")
    assert obj.npmesh.problem == "" and (folder / "shape.npmesh").read_bytes() == stream
    assert "numba" not in sys.modules, "Blender's process has loaded numba"
    bpy.context.view_layer.objects.active = obj
    with in_viewport():
        bpy.ops.object.npmesh_pack("EXEC_DEFAULT", True)
    yield from shown()
    shown_is_decoded(obj)
    undo()
    yield from shown()
    assert module("preview").is_linked(bpy.data.objects[name]), "undo leaves the stream packed"
    (folder / "shape.npmesh").unlink()
    with in_viewport():
        bpy.ops.wm.open_mainfile(filepath=blend)
    yield from until(lambda: name in bpy.data.objects)
    assert "found none; check the path" in bpy.data.objects[name].npmesh.problem
    yield 0.5
