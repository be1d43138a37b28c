"""The stream that an object keeps: packed in the .blend, as custom properties, or linked from a file.

Of a linked file the object has the path and the digest, and what was measured; see `linked` for reading it. `foreign`
says whether an object is ours to change.
"""
import hashlib
from functools import lru_cache
from typing import TYPE_CHECKING

import bpy

from .opening import receive

if TYPE_CHECKING:
    from ..core.codec import StoredStream
    from ..core.evaluation import PrefixErrors

STREAM = "npmesh_stream"  # the packed bytes
ARRAYS = "npmesh_arrays"  # what was read from them, so that they open without compiled code
MEASURED = "npmesh_measured"  # text of the measured errors; not there for a file that was opened without its original


def digest_of(data: bytes) -> str:
    """The name of a stream, from its bytes."""
    return hashlib.blake2b(data, digest_size=16).hexdigest()


def pack(obj: bpy.types.Object, received: "StoredStream") -> None:
    """Keep a stream on an object, in the .blend.

    A property that exists is removed first: assigned over another, bytes end at their first zero (Blender 4.5, 5.2).
    """
    unpack(obj)
    obj[STREAM], obj[ARRAYS] = received.data, received.arrays
    if received.measured:
        obj[MEASURED] = received.measured
    obj.npmesh.filepath = ""


def unpack(obj: bpy.types.Object) -> None:
    """Remove what `pack` kept."""
    for name in (STREAM, ARRAYS, MEASURED):
        if name in obj:
            del obj[name]


def has_stream(obj: bpy.types.Object) -> bool:
    """Whether a stream is packed on an object."""
    return isinstance(obj.get(STREAM), bytes)


def is_linked(obj: bpy.types.Object) -> bool:
    """Whether the stream of an object is in a file of its own."""
    return bool(obj.npmesh.filepath) and not has_stream(obj)


def foreign(obj: bpy.types.Object) -> str:
    """Why an object and its meshes are not ours to change; empty if they are."""
    if obj.library is not None:
        return f"Expected a local preview, found '{obj.name}' linked from a file; make it local first"
    if obj.override_library is not None:
        return f"Expected a local preview, found '{obj.name}', a library override; make it local first"
    return ""


def packed(obj: bpy.types.Object) -> "StoredStream | None":
    """The stream that is packed on an object, if there is one. Raises StreamError or DependencyError if it is damaged."""
    from ..core.codec import StoredStream

    if not has_stream(obj):
        return None
    data, arrays = obj[STREAM], obj.get(ARRAYS)
    return StoredStream(data, arrays if isinstance(arrays, bytes) else receive(data).arrays, measured_text(obj))


def measured_text(obj: bpy.types.Object) -> str:
    """The measured errors of the stream, as text; empty if they are not known."""
    text = obj.get(MEASURED)
    return text if isinstance(text, str) else ""


@lru_cache(maxsize=16)
def quality(text: str) -> "PrefixErrors | None":
    """The errors that `measured_text` tells of, None if they are not known. Raises StreamError if it is damaged."""
    from ..core.evaluation import prefix_errors_from_text

    return prefix_errors_from_text(text) if text else None
