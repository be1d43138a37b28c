"""The stream of a preview, wherever it is kept, and the mesh that it opens to."""
from typing import TYPE_CHECKING

import bpy

from ..core.errors import StreamError
from . import decoder_cache, linked, storage
from .opening import open_received

if TYPE_CHECKING:
    from ..core.codec import ProgressiveMesh, StoredStream


def progressive_of(obj: bpy.types.Object) -> "ProgressiveMesh":
    """The opened stream of a preview. Raises StreamError, FileError, WeightsError or DependencyError."""
    return decoder_cache.get(obj.npmesh.digest, lambda: open_received(received_of(obj)))


def received_of(obj: bpy.types.Object) -> "StoredStream":
    """The stream of a preview, packed or linked. Raises StreamError, FileError or DependencyError."""
    received = linked.read(obj) if storage.is_linked(obj) else storage.packed(obj)
    if received is None:
        raise StreamError(f"Expected the compressed stream in '{obj.name}', found none; open the file again")
    return received
