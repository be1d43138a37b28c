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
# the kinds of change that are timed; `own` is the extension's processor time
NAMES = ("new", "new_own", "known", "known_own", "plain", "redraw", "switch", "switch_own", "plain_switch")
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


class UpdateTimer:
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


class Comparison:
    """The same changes of a preview and of an ordinary object; `times`: milliseconds of each kind of change, by name."""

    def __init__(self, drag, stamp: str) -> None:
        """drag: a slider.Drag that has shown every level; stamp: the property of a mesh that says what it holds."""
        self.drag, self.stamp = drag, stamp
        self.viewport, self.timer, self.plain = Viewport(), UpdateTimer(drag.updates), Plain(drag.obj)
        self.times: dict[str, list[float]] = {name: [] for name in NAMES}

    def end(self) -> None:
        """Watch no more, and remove the ordinary object."""
        for part in (self.viewport, self.timer, self.plain):
            part.end()

    def show_only(self, obj: bpy.types.Object) -> Generator[None, None, None]:
        """Hide the other of the two objects."""
        for other in (self.drag.obj, self.plain.obj):
            other.hide_set(other != obj)
        yield from _frames()

    def move(self, features: int, *names: str) -> Frames:
        """Set the slider; names: where the time until it was drawn goes, and of it the extension's own."""
        obj, state = self.drag.obj, self.drag.state
        wanted = f"{state.digest}:{features}"
        if obj.data.get(self.stamp) == wanted:  # two positions with as many features: nothing moves
            return
        self.timer.take()
        took = yield from self.viewport.visible(lambda: setattr(state, "features", features),
                                                lambda: obj.data.get(self.stamp) == wanted)
        for name, value in zip(names, (took, self.timer.take()), strict=False):
            self.times[name].append(value)

    def switch(self, level: int) -> Frames:
        """Show another level of the preview."""
        obj, state = self.drag.obj, self.drag.state
        mesh = state.meshes[level].mesh
        if obj.data == mesh:
            return
        self.timer.take()
        took = yield from self.viewport.visible(lambda: setattr(state, "level", str(level)), lambda: obj.data == mesh)
        self.times["switch"].append(took)
        self.times["switch_own"].append(self.timer.take())

    def moves(self, there: list[int], known: int) -> Generator[None, None, None]:
        """One round of the slider; the first `known` positions of the way back in turns with the ordinary object."""
        area = _viewport(bpy.context.window_manager.windows[0])
        visible, half = self.viewport.visible, len(there) // 2
        yield from self.show_only(self.drag.obj)
        for k in there[:half]:
            yield from self.move(k, "new", "new_own")
        for block in _blocks(there[half:half + known]):
            yield from self.show_only(self.drag.obj)
            drawn = []
            for k in block:
                yield from self.move(k, "known", "known_own")
                drawn.append(positions_of(self.drag.obj.data))
            yield from self.show_only(self.plain.obj)
            for positions in drawn:
                self.times["plain"].append((yield from visible(lambda p=positions: self.plain.move(p), lambda: True)))
            for _ in block:
                self.times["redraw"].append((yield from visible(area.tag_redraw, lambda: True)))
        yield from self.show_only(self.drag.obj)
        for k in there[half + known:]:
            yield from self.move(k)

    def switches(self, count: int) -> Generator[None, None, None]:
        """So many changes of level, in turns with those of the ordinary object."""
        finest, levels = self.drag.state.level, len(self.plain.levels)
        for level in (*range(levels), int(finest)):
            self.drag.switch(level)  # brings each to the features
        for block in _blocks([k % levels for k in range(count)]):
            yield from self.show_only(self.drag.obj)
            for level in block:
                yield from self.switch(level)
            yield from self.show_only(self.plain.obj)
            for level in block:
                took = yield from self.viewport.visible(lambda v=level: self.plain.switch(v), lambda: True)
                self.times["plain_switch"].append(took)
        self.drag.state.level = finest


def measured(drag, rounds: list[list[int]], known: int, switches: int, stamp: str) -> Generator[None, None, dict]:
    """Times in milliseconds, lists by name, as the generator's return value; it yields where Blender goes on.

    drag: a slider.Drag that has shown every level; rounds: positions there and back; known: how many of the way back were
    seen just before; stamp: the property of a mesh that says what it holds. `plain` are the same changes of an ordinary
    object, in turns of BLOCK with those of the preview; `redraw` is a frame for which nothing has changed.
    """
    comparison = Comparison(drag, stamp)
    for there in rounds:
        yield from comparison.moves(there, known)
    yield from comparison.switches(switches)
    comparison.end()
    return comparison.times


def _blocks(values: list[int]) -> list[list[int]]:
    return [values[k:k + BLOCK] for k in range(0, len(values), BLOCK)]
