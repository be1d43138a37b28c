"""From setting the slider to the drawn mesh, in a window; see slider.py.

Every move goes the way of a user's: the property is set from Blender's main loop, the extension follows as it does, and
the viewport's own draw handler says when a mesh has been drawn (a pixel is read back, so that drawing has ended). The
same positions, written to the mesh of an ordinary object, and that object's levels, swapped, tell what Blender's drawing
costs without the extension; a frame for which nothing has changed tells what no change could save.
Without a graphics card drawing dwarfs the rest, so it is made cheap: one viewport, small, flat, without anti-aliasing
and overlays; give Blender a small window too (`--window-geometry 0 0 320 240`).
"""
import time
from collections.abc import Callable, Generator

import bpy
import gpu
import numpy as np

LIMIT_SECONDS = 20
BLOCK = 12  # changes of one object before the other's turn; all levels as often
SHARE = 0.3  # of the window's width and height that the viewport keeps
Frames = Generator[None, None, float]


def make_drawing_cheap() -> Generator[None, None, None]:
    """One small viewport, which draws triangles in one colour; yields where Blender has to draw once."""
    bpy.context.preferences.system.viewport_aa = "OFF"
    window = bpy.context.window_manager.windows[0]
    for direction in ("VERTICAL", "HORIZONTAL"):
        yield from _frames()
        area = _viewport(window)
        with bpy.context.temp_override(window=window, area=area, region=area.regions[-1]):
            bpy.ops.screen.area_split(direction=direction, factor=SHARE)
        small = min((a for a in window.screen.areas if a.type == "VIEW_3D"), key=lambda a: a.width * a.height)
        for area in [a for a in window.screen.areas if a != small]:
            area.type = "TEXT_EDITOR"  # draws nothing that changes
    yield from _frames()
    space = _viewport(window).spaces.active
    space.overlay.show_overlays = space.show_gizmo = False
    space.show_region_ui = space.show_region_toolbar = space.show_region_header = space.show_region_tool_header = False
    space.shading.type, space.shading.light, space.shading.color_type = "SOLID", "FLAT", "SINGLE"
    space.shading.show_object_outline = False
    yield from _frames()


def _viewport(window: bpy.types.Window) -> bpy.types.Area:
    return next(a for a in window.screen.areas if a.type == "VIEW_3D")


def _frames() -> Generator[None, None, None]:
    for _ in range(20):
        yield


class Viewport:
    """Knows when a mesh was last drawn in the viewport."""

    def __init__(self) -> None:
        """Begin to watch."""
        self._expected: Callable[[], bool] | None = None
        self._drawn = 0.0
        self._handler = bpy.types.SpaceView3D.draw_handler_add(self._draw, (), "WINDOW", "POST_PIXEL")

    def end(self) -> None:
        """Watch no more."""
        bpy.types.SpaceView3D.draw_handler_remove(self._handler, "WINDOW")

    def _draw(self) -> None:
        if self._expected is not None and self._expected():
            gpu.state.active_framebuffer_get().read_color(0, 0, 1, 1, 4, 0, "FLOAT")  # waits for what was drawn before
            self._drawn, self._expected = time.perf_counter(), None

    def visible(self, change: Callable[[], object], expected: Callable[[], bool]) -> Frames:
        """Milliseconds from before `change` until a frame was drawn in which `expected` held."""
        start = time.perf_counter()
        self._expected = expected
        change()
        while self._expected is not None:
            if time.perf_counter() > start + LIMIT_SECONDS:
                raise RuntimeError("Expected the viewport to be drawn, found it was not; is the window covered?")
            yield
        return 1000 * (self._drawn - start)


class Plain:
    """An ordinary object with the preview's meshes, which the extension knows nothing of."""

    def __init__(self, obj: bpy.types.Object) -> None:
        """Make it of the levels of `obj`, all of which were shown; it shows the same one."""
        shown = [item.mesh for item in obj.npmesh.meshes]
        self.levels = [mesh.copy() for mesh in shown]
        for mesh in self.levels:
            for key in list(mesh.keys()):
                del mesh[key]
        self.obj = bpy.data.objects.new("Plain", self.levels[shown.index(obj.data)])
        bpy.context.collection.objects.link(self.obj)

    def move(self, positions: np.ndarray) -> None:
        """Put the vertices at positions (3 n,) float32."""
        self.obj.data.attributes["position"].data.foreach_set("vector", positions)
        self.obj.data.update()

    def switch(self, level: int) -> None:
        """Show the mesh of another level."""
        self.obj.data = self.levels[level]

    def end(self) -> None:
        """Remove it."""
        for mesh in self.levels:
            bpy.data.meshes.remove(mesh)


def positions_of(mesh: bpy.types.Mesh) -> np.ndarray:
    """Positions of the vertices, (3 n,) float32."""
    out = np.zeros(3 * len(mesh.vertices), dtype=np.float32)
    mesh.attributes["position"].data.foreach_get("vector", out)
    return out


class Clock:
    """Milliseconds of processor time of the window's thread in the extension's updates, since `take` was called."""

    def __init__(self, updates) -> None:
        """updates: the extension's module preview.updates."""
        self._spent, self._updates, self._show = 0.0, updates, updates.show_or_say

        def timed(obj: bpy.types.Object) -> None:
            start = time.thread_time()
            self._show(obj)
            self._spent += 1000 * (time.thread_time() - start)

        updates.show_or_say = timed

    def take(self) -> float:
        """What was spent."""
        spent, self._spent = self._spent, 0.0
        return spent

    def end(self) -> None:
        """Count no more."""
        self._updates.show_or_say = self._show


def measured(drag, rounds: list[list[int]], known: int, switches: int, stamp: str) -> Generator[None, None, dict]:
    """Times in milliseconds, lists by name, as the generator's return value; it yields where Blender goes on.

    drag: a slider.Drag that has shown every level; rounds: positions there and back; known: how many of the way back were
    seen just before; stamp: the property of a mesh that says what it holds. `plain` are the same changes of an ordinary
    object, in turns of BLOCK with those of the preview; `redraw` is a frame for which nothing has changed.
    """
    viewport, clock = Viewport(), Clock(drag.updates)
    plain, area = Plain(drag.obj), _viewport(bpy.context.window_manager.windows[0])
    times: dict[str, list[float]] = {name: [] for name in ("new", "new_own", "known", "known_own", "plain", "redraw",
                                                           "switch", "switch_own", "plain_switch")}

    def move(features: int, *names: str) -> Frames:
        wanted = f"{drag.state.digest}:{features}"
        if drag.obj.data.get(stamp) == wanted:  # two positions with as many features: nothing moves
            return
        clock.take()
        took = yield from viewport.visible(lambda: setattr(drag.state, "features", features),
                                           lambda: drag.obj.data.get(stamp) == wanted)
        for name, value in zip(names, (took, clock.take()), strict=False):
            times[name].append(value)

    def switch(level: int) -> Frames:
        mesh = drag.state.meshes[level].mesh
        if drag.obj.data == mesh:
            return
        clock.take()
        took = yield from viewport.visible(lambda: setattr(drag.state, "level", str(level)), lambda: drag.obj.data == mesh)
        times["switch"].append(took)
        times["switch_own"].append(clock.take())

    def only(obj: bpy.types.Object) -> Generator[None, None, None]:
        for other in (drag.obj, plain.obj):
            other.hide_set(other != obj)
        yield from _frames()

    for there in rounds:
        yield from only(drag.obj)
        half = len(there) // 2
        for k in there[:half]:
            yield from move(k, "new", "new_own")
        for block in _blocks(there[half:half + known]):
            yield from only(drag.obj)
            drawn = []
            for k in block:
                yield from move(k, "known", "known_own")
                drawn.append(positions_of(drag.obj.data))
            yield from only(plain.obj)
            for positions in drawn:
                times["plain"].append((yield from viewport.visible(lambda p=positions: plain.move(p), lambda: True)))
            for _ in block:
                times["redraw"].append((yield from viewport.visible(area.tag_redraw, lambda: True)))
        yield from only(drag.obj)
        for k in there[half + known:]:
            yield from move(k)
    finest = drag.state.level
    for level in (*range(len(plain.levels)), int(finest)):
        drag.switch(level)  # brings each to the features
    for block in _blocks([k % len(plain.levels) for k in range(switches)]):
        yield from only(drag.obj)
        for level in block:
            yield from switch(level)
        yield from only(plain.obj)
        for level in block:
            times["plain_switch"].append((yield from viewport.visible(lambda v=level: plain.switch(v), lambda: True)))
    drag.state.level = finest
    for part in (viewport, clock, plain):
        part.end()
    return times


def _blocks(values: list[int]) -> list[list[int]]:
    return [values[k:k + BLOCK] for k in range(0, len(values), BLOCK)]
