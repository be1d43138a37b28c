"""Opened streams, kept by digest while Blender runs; the last few, as each takes some megabytes."""
from collections import OrderedDict
from collections.abc import Callable, Generator
from typing import TYPE_CHECKING

from ..core.errors import NpmError
from ..runtime.dependencies import named_dependencies
from .opening import open_received
from .storage import digest_of
from .threads import in_thread

if TYPE_CHECKING:
    from ..core.codec import ProgressiveMesh, StoredStream

KEPT = 8

_kept: "OrderedDict[str, ProgressiveMesh]" = OrderedDict()


def get(digest: str, open_it: "Callable[[], ProgressiveMesh]") -> "ProgressiveMesh":
    """The opened stream of this digest; what `open_it` returns, if it is not among those that are kept."""
    if digest not in _kept:
        keep(digest, open_it())
    _kept.move_to_end(digest)
    return _kept[digest]


def progressive_in(received: "StoredStream") -> "ProgressiveMesh":
    """The opened stream, from the kept ones if it is there. Raises StreamError, WeightsError or DependencyError."""
    return get(digest_of(received.data), lambda: open_received(received))


def open_ahead(received: "StoredStream") -> Generator[None, None, None]:
    """Open a stream and decode all of it in a thread, so that the preview that is made then is there at once.

    Raises StreamError, WeightsError or DependencyError.
    """
    digest = digest_of(received.data)
    if digest in _kept:  # others use it already
        return

    def work() -> "ProgressiveMesh":
        progressive = open_received(received)
        for rung in progressive.rungs:  # connectivity of all, so that the slider finds it
            progressive.decode_positions(rung.features)
        progressive.decode_positions()
        return progressive

    keep(digest, (yield from in_thread(work)))


def warm_up() -> Generator[None, None, None]:
    """Load what opening a stream needs, while a job runs, in steps: it takes as long as opening.

    Problems show when a stream is opened.
    """
    def load() -> None:
        from ..core.codec import StoredStream  # noqa: F401

    try:
        with named_dependencies():
            yield from in_thread(load)
    except NpmError:
        pass


def keep(digest: str, progressive: "ProgressiveMesh") -> None:
    """Remember an opened stream."""
    _kept[digest] = progressive
    while len(_kept) > KEPT:
        _kept.popitem(last=False)


def drop(digest: str) -> None:
    """Let a stream be opened again when it is next needed."""
    _kept.pop(digest, None)


def forget() -> None:
    """Drop all."""
    _kept.clear()
