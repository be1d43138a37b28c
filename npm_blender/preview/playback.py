"""Playing a stream as it would arrive over a line: what is there after so many seconds, and where the play began."""
import time

import bpy

from .streams import progressive_of


class Play:
    """One preview that is being played.

    elapsed: seconds; arrived: bytes so far; base, end: bytes at which the base mesh is there, and at which the play
    ends; features: those that were set before.
    """

    def __init__(self, obj: bpy.types.Object) -> None:
        """Begin. Raises StreamError, FileError, WeightsError or DependencyError."""
        progressive, state = progressive_of(obj), obj.npmesh
        self.uid, self.features = obj.session_uid, state.features
        self.base, self.end = progressive.base_bytes, progressive.bytes_for(state.features)
        self.elapsed, self.arrived = 0.0, 0
        self._bytes_per_second = state.play_rate * 1000 / 8
        self._begun = time.monotonic()

    @property
    def fraction(self) -> float:
        """Share of the bytes that have arrived."""
        return self.arrived / self.end

    def step(self, obj: bpy.types.Object) -> bool:
        """Show what has arrived by now; False at the end."""
        self.elapsed = time.monotonic() - self._begun
        self.arrived = min(int(self.elapsed * self._bytes_per_second), self.end)
        if self.arrived == self.end:
            self.elapsed = self.end / self._bytes_per_second
            features = self.features
        else:
            features = progressive_of(obj).features_for(max(self.arrived, self.base))
        if obj.npmesh.features != features:
            obj.npmesh.features = features
        return self.arrived < self.end


_plays: dict[int, Play] = {}  # by session_uid


def start(obj: bpy.types.Object) -> Play:
    """Begin to play a preview; raises as `Play` does."""
    _plays[obj.session_uid] = Play(obj)
    return _plays[obj.session_uid]


def of(obj: bpy.types.Object) -> Play | None:
    """The play of an object, if it is being played."""
    return _plays.get(obj.session_uid)


def is_playing(obj: bpy.types.Object) -> bool:
    """Whether an object is being played."""
    return obj.session_uid in _plays


def is_running(play: Play) -> bool:
    """Whether a play goes on."""
    return _plays.get(play.uid) is play


def drop(play: Play) -> None:
    """End a play whose object is gone."""
    if is_running(play):
        del _plays[play.uid]


def stop(obj: bpy.types.Object) -> None:
    """End playing; the features are what they were before."""
    play = _plays.pop(obj.session_uid, None)
    if play is not None and obj.npmesh.is_preview:
        obj.npmesh.features = play.features


def stop_all() -> None:
    """End all playing."""
    for obj in [o for o in bpy.data.objects if o.session_uid in _plays]:
        stop(obj)
    _plays.clear()


def forget_all() -> None:
    """End all playing without a change: the properties are of another time."""
    _plays.clear()
