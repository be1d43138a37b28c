"""Arrays to bytes and back."""
from typing import TYPE_CHECKING

from ..lazy import lazy_exports

if TYPE_CHECKING:
    from .compression import Compressed, CompressReport, compress
    from .progressive_mesh import ProgressiveMesh, RungFacts, open_stream
    from .stored_stream import StoredStream, receive

__all__ = [
    "CompressReport",
    "Compressed",
    "ProgressiveMesh",
    "RungFacts",
    "StoredStream",
    "compress",
    "open_stream",
    "receive",
]
__getattr__, __dir__ = lazy_exports(__name__, {
    "compression": ("CompressReport", "Compressed", "compress",),
    "progressive_mesh": ("ProgressiveMesh", "RungFacts", "open_stream",),
    "stored_stream": ("StoredStream", "receive",),
})
