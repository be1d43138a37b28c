"""When previews follow their properties: at once if that is fast, else from a timer; after undo; before saving."""
import time

import bpy

from ..core.errors import NpmError
from . import decoder_cache, deviation, levels, linked, playback, storage, viewport

# An update that takes longer waits until the panel has been drawn with the slider's new place. It costs one redraw more;
# Blender itself passes on only the last of the mouse's moves that are waiting.
FAST_SECONDS = 0.1

_seconds: dict[str, float] = {}  # what the last update of a stream took
_waiting: set[int] = set()  # session_uid of objects that the timer will update


def set_features(state, features: int) -> None:
    """Use this many features, at most those that arrived."""
    state.kept_features = min(features, state.arrived_features) if state.is_preview else features
    _follow(state)


def set_level(state, level: int) -> None:
    """Show this level, or the finest."""
    state.kept_level = min(level, state.level_count) if state.is_preview else level
    _follow(state)


def _follow(state) -> None:
    """Show what the properties say, now or from the timer."""
    obj = state.id_data
    if not state.is_preview or obj.mode != "OBJECT" or storage.foreign(obj):
        return
    if bpy.app.background or _seconds.get(state.digest, 0.0) <= FAST_SECONDS:
        show_or_say(obj)
        return
    _waiting.add(obj.session_uid)
    if not bpy.app.timers.is_registered(flush):
        bpy.app.timers.register(flush)


def on_path(state, context: bpy.types.Context) -> None:
    """Update callback of the path of a linked file: look there, if the stream could not be found before."""
    obj = state.id_data
    if state.is_preview and state.problem and state.filepath and not storage.foreign(obj):
        decoder_cache.drop(state.digest)
        show_or_say(obj)


def flush() -> None:
    """Show what waits for the timer."""
    uids = set(_waiting)
    _waiting.clear()
    for obj in [o for o in bpy.data.objects if o.session_uid in uids] if uids else []:
        if obj.npmesh.is_preview and obj.mode == "OBJECT":
            show_or_say(obj)


def is_busy() -> bool:
    """Whether a preview has still to follow its properties."""
    return bool(_waiting) or deviation.is_busy()


def show_or_say(obj: bpy.types.Object) -> None:
    """`show` where no operator could report: the panel says what is wrong."""
    start = time.perf_counter()
    try:
        if levels.show(obj):
            _seconds[obj.npmesh.digest] = time.perf_counter() - start
        deviation.request(obj)
    except NpmError as error:
        obj.npmesh.problem = str(error)
    viewport.redraw_panels()


@bpy.app.handlers.persistent
def refresh_all(*_args: object) -> None:
    """After undo and redo: every preview shows what its properties say."""
    playback.forget_all()
    _waiting.clear()
    for obj in [o for o in bpy.data.objects if o.npmesh.is_preview and not storage.foreign(o) and o.mode == "OBJECT"]:
        if not levels.is_shown(obj):
            show_or_say(obj)
    deviation.follow_all()


@bpy.app.handlers.persistent
def after_load(*_args: object) -> None:
    """After a .blend was opened: linked files are looked at, colours and viewports follow."""
    linked.check_all()
    deviation.follow_all()


@bpy.app.handlers.persistent
def before_save(path: str, *_args: object) -> None:
    """What is saved is what the user set: playing ends, meshes and paths follow."""
    playback.stop_all()
    refresh_all()
    linked.before_save(path)


@bpy.app.handlers.persistent
def forget_all(*_args: object) -> None:
    """Drop opened streams and pending updates: another file is being loaded, or the extension is being disabled."""
    _waiting.clear()
    decoder_cache.forget()
    deviation.forget_all()
    linked.forget_all()
    playback.forget_all()
    _seconds.clear()
    if bpy.app.timers.is_registered(flush):
        bpy.app.timers.unregister(flush)
