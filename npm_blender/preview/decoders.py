"""Opened streams, kept by digest while Blender runs; the last few, as each takes some megabytes."""
from collections import OrderedDict
from collections.abc import Generator
from typing import TYPE_CHECKING

import bpy

from ..core.errors import NpmError, StreamError
from ..dependencies import named_dependencies, open_received
from . import kept
from .threads import in_thread

if TYPE_CHECKING:
    from ..core.codec.progressive_mesh import ProgressiveMesh
    from ..core.codec.stored_stream import StoredStream

KEPT_DECODERS = 8

_decoders: "OrderedDict[str, ProgressiveMesh]" = OrderedDict()


def decoder_of(obj: bpy.types.Object) -> "ProgressiveMesh":
    """The opened stream of a preview. Raises StreamError, FileError, WeightsError or DependencyError."""
    digest = obj.npmesh.digest
    if digest not in _decoders:
        keep(digest, open_received(received_of(obj)))
    _decoders.move_to_end(digest)
    return _decoders[digest]


def received_of(obj: bpy.types.Object) -> "StoredStream":
    """The stream of a preview, packed or linked. Raises StreamError, FileError or DependencyError."""
    from . import linked  # which opens streams, too

    received = linked.read(obj) if kept.is_linked(obj) else kept.packed(obj)
    if received is None:
        raise StreamError(f"Expected the compressed stream in '{obj.name}', found none; open the file again")
    return received


def opened(received: "StoredStream") -> "ProgressiveMesh":
    """The opened stream, from the kept ones if it is there. Raises StreamError, WeightsError or DependencyError."""
    digest = kept.digest_of(received.data)
    if digest not in _decoders:
        keep(digest, open_received(received))
    _decoders.move_to_end(digest)
    return _decoders[digest]


def opened_ahead(received: "StoredStream") -> Generator[None, None, None]:
    """Open a stream and decode all of it in a thread, so that the preview that is made then is there at once.

    Raises StreamError, WeightsError or DependencyError.
    """
    digest = kept.digest_of(received.data)
    if digest in _decoders:  # others use it already
        return

    def work() -> "ProgressiveMesh":
        decoder = open_received(received)
        decoder.decode_positions()
        return decoder

    keep(digest, (yield from in_thread(work)))


def warm_up() -> Generator[None, None, None]:
    """Load what opening a stream needs, while a job runs, in steps: it takes as long as opening.

    Problems show when a stream is opened.
    """
    def load() -> None:
        from ..core.codec import stored_stream  # noqa: F401
        from ..core.network import weights  # noqa: F401

        weights.load()

    try:
        with named_dependencies():
            yield from in_thread(load)
    except NpmError:
        pass


def keep(digest: str, decoder: "ProgressiveMesh") -> None:
    """Remember an opened stream."""
    _decoders[digest] = decoder
    while len(_decoders) > KEPT_DECODERS:
        _decoders.popitem(last=False)


def drop(digest: str) -> None:
    """Let a stream be opened again when it is next needed."""
    _decoders.pop(digest, None)


def forget() -> None:
    """Drop all."""
    _decoders.clear()
