"""The deviation of a preview: its distance to the original, vertex by vertex, as a colour attribute.

Computed in steps from a timer, at once where there is no window. A mesh is stamped with what its colours are of, so that
undo, redo and another stop of the slider show what is to do.
"""
import math
import time
from collections.abc import Generator

import bpy

from .. import bridge
from ..core.errors import MeshError, NpmError
from . import levels, storage, viewport
from .nearest import Nearest

ATTRIBUTE = "Deviation"
STAMP = "npmesh_deviation"  # custom property of a level's mesh: its positions and the scale that the colours are of
# sRGB, from no distance to the top of the scale; lightness rises and falls again so that grey prints tell them apart
COLOURS = ((0.16, 0.27, 0.62), (0.20, 0.62, 0.74), (0.80, 0.86, 0.66), (0.98, 0.70, 0.28), (0.78, 0.10, 0.13))
STEP_SECONDS, PAUSE_SECONDS, WATCH_SECONDS = 0.012, 0.01, 1.0

_tasks: dict[int, Generator[None, None, None]] = {}  # by session_uid of the preview
_surfaces: dict[int, Nearest] = {}
_distances: dict[int, tuple[str, object]] = {}  # the last ones, with the stamp of their positions
_choosing: list[bool] = []  # not empty while the scale is set here and not by the user


def on_toggle(state, context: bpy.types.Context) -> None:
    """Update callback: compute or remove the colours; the viewports follow."""
    obj = state.id_data
    forget(obj)
    if state.is_preview:
        state.deviation_problem = ""
        if not state.show_deviation:
            _remove(obj)
        request(obj)
    _watch()


def on_scale(state, context: bpy.types.Context) -> None:
    """Update callback: the same distances in other colours."""
    if not _choosing:
        request(state.id_data)


def request(obj: bpy.types.Object) -> None:
    """Let the colours follow what the preview shows, if it shows its deviation."""
    state = obj.npmesh
    if not (state.is_preview and state.show_deviation) or state.problem or _is_current(obj):
        return
    _tasks[obj.session_uid] = _work(obj.session_uid)
    if bpy.app.background:
        for _ in _tasks.pop(obj.session_uid):
            pass
    elif not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=PAUSE_SECONDS)


def is_busy() -> bool:
    """Whether colours are being computed."""
    return bool(_tasks)


def forget(obj: bpy.types.Object) -> None:
    """Drop what is known of the original of `obj`, which may have changed."""
    for known in (_tasks, _surfaces, _distances):
        known.pop(obj.session_uid, None)


def forget_all() -> None:
    """Drop everything, and the timers."""
    for known in (_tasks, _surfaces, _distances):
        known.clear()
    for timer in (_tick, _watching):
        if bpy.app.timers.is_registered(timer):
            bpy.app.timers.unregister(timer)


def end(obj: bpy.types.Object) -> None:
    """The preview ends: its meshes lose their colours, the viewports what they were switched to."""
    forget(obj)
    _remove(obj)
    obj.npmesh.show_deviation = False


def legend(state) -> list[tuple[float, tuple[float, float, float]]]:
    """The scale: distances in units of the object, and their colours (sRGB), the largest first."""
    count = 2 * len(COLOURS) - 1
    return [(state.deviation_top * k / (count - 1), _colour(k / (count - 1))) for k in reversed(range(count))]


def _work(uid: int) -> Generator[None, None, None]:
    """All steps for the preview with this uid, which may go or change in between."""
    import numpy as np

    obj = _find(uid)
    try:
        surface = _surface(obj)
    except NpmError as error:
        obj.npmesh.deviation_problem = str(error)
        return
    yield from surface.build()
    obj = _find(uid)
    if obj is None or obj.mode != "OBJECT":
        return
    positions = str(obj.data.get(levels.STAMP))
    known, distance = _distances.get(uid, ("", None))
    if known != f"{positions}:{len(obj.data.vertices)}":
        P = np.zeros((len(obj.data.vertices), 3), dtype=np.float32)
        obj.data.vertices.foreach_get("co", P.reshape(-1))
        distance = yield from surface.distances(P)
        _distances[uid] = f"{positions}:{len(P)}", distance
        obj = _find(uid)
    shown = obj is not None and obj.npmesh.show_deviation and obj.mode == "OBJECT"
    if shown and obj.data.get(levels.STAMP) == positions and len(obj.data.vertices) == len(distance):
        _paint(obj, distance)


def _surface(obj: bpy.types.Object) -> Nearest:
    """The search for points on the original. Raises MeshError if there is none, or it has no faces."""
    source = obj.npmesh.source
    if source is None:
        raise MeshError("Expected the original, found none: the preview was opened from a file; import the original, "
                        "compress it, and compare there")
    if obj.session_uid not in _surfaces:
        _surfaces[obj.session_uid] = Nearest(bridge.mesh_of(source, bpy.context.evaluated_depsgraph_get()))
    return _surfaces[obj.session_uid]


def _paint(obj: bpy.types.Object, distance) -> None:
    """Write the colours of distances (n,), and their mean and maximum."""
    import numpy as np

    state, mesh = obj.npmesh, obj.data
    if state.deviation_top <= 0:
        _choosing.append(True)
        state.deviation_top = _round_up(float(np.percentile(distance, 99)))
        _choosing.clear()
    attribute = mesh.color_attributes.get(ATTRIBUTE)
    if attribute is None or attribute.domain != "POINT" or attribute.data_type != "FLOAT_COLOR":
        if attribute is not None:
            mesh.color_attributes.remove(attribute)
        attribute = mesh.color_attributes.new(ATTRIBUTE, "FLOAT_COLOR", "POINT")
    at = np.clip(distance / state.deviation_top, 0, 1) * (len(COLOURS) - 1)
    colours = np.ones((len(distance), 4), dtype=np.float32)
    for k, channel in enumerate(np.array(COLOURS).T):
        colours[:, k] = _linear(np.interp(at, np.arange(len(COLOURS)), channel))
    attribute.data.foreach_set("color", colours.reshape(-1))
    mesh.color_attributes.active_color = attribute
    mesh.update()
    mesh[STAMP] = _stamp(obj)
    state.deviation_mean, state.deviation_max = float(distance.mean()), float(distance.max())
    _redraw()


def _stamp(obj: bpy.types.Object) -> str:
    return f"{obj.data.get(levels.STAMP)}:{obj.npmesh.deviation_top:.6g}"


def _is_current(obj: bpy.types.Object) -> bool:
    return ATTRIBUTE in obj.data.color_attributes and obj.data.get(STAMP) == _stamp(obj)


def _remove(obj: bpy.types.Object) -> None:
    for mesh in levels.level_meshes(obj):
        attribute = mesh.color_attributes.get(ATTRIBUTE)
        if attribute is not None:
            mesh.color_attributes.remove(attribute)
        if STAMP in mesh:
            del mesh[STAMP]


def _find(uid: int) -> bpy.types.Object | None:
    return next((o for o in bpy.data.objects if o.session_uid == uid and o.npmesh.is_preview), None)


def _tick() -> float | None:
    """Do steps for a moment; called by Blender's timer until nothing is left."""
    end = time.perf_counter() + STEP_SECONDS
    while _tasks and time.perf_counter() < end:
        uid, task = next(iter(_tasks.items()))
        if _find(uid) is None or next(task, self_ended := object()) is self_ended:
            _tasks.pop(uid, None)
    return PAUSE_SECONDS if _tasks else None


def _watch() -> None:
    """Switch the viewports, and back as soon as no preview shows its deviation, whatever ends it."""
    if viewport.sync() and not bpy.app.background and not bpy.app.timers.is_registered(_watching):
        bpy.app.timers.register(_watching, first_interval=WATCH_SECONDS)


def _watching() -> float | None:
    return WATCH_SECONDS if viewport.sync() else None


def follow_all() -> None:
    """After undo, redo and loading: colours and viewports follow."""
    for obj in [o for o in bpy.data.objects if o.npmesh.show_deviation and not storage.foreign(o) and o.mode == "OBJECT"]:
        request(obj)
    _watch()


def _redraw() -> None:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def _colour(at: float) -> tuple[float, float, float]:
    k = min(int(at * (len(COLOURS) - 1)), len(COLOURS) - 2)
    share = at * (len(COLOURS) - 1) - k
    return tuple((1 - share) * a + share * b for a, b in zip(COLOURS[k], COLOURS[k + 1], strict=True))


def _linear(srgb):
    """sRGB (n,) in 0..1 to linear light."""
    import numpy as np

    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def _round_up(value: float) -> float:
    """The next of 1, 2 and 5 times a power of ten."""
    if value <= 0:
        return 1e-6
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1, 2, 5, 10) if step * power >= value)
