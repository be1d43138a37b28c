"""Arrays to bytes and back."""
from typing import TYPE_CHECKING

from ..lazy import lazy_exports

if TYPE_CHECKING:
    from .compression import Compressed, CompressReport, compress
    from .importance import LATENTS
    from .progressive_mesh import ProgressiveMesh, open_stream
    from .rate_control import base_faces_for, level_count_for
    from .stored_stream import StoredStream, receive

__all__ = [
    "CompressReport",
    "Compressed",
    "LATENTS",
    "ProgressiveMesh",
    "StoredStream",
    "base_faces_for",
    "compress",
    "level_count_for",
    "open_stream",
    "receive",
]
__getattr__, __dir__ = lazy_exports(__name__, {
    "compression": ("CompressReport", "Compressed", "compress",),
    "importance": ("LATENTS",),
    "progressive_mesh": ("ProgressiveMesh", "open_stream",),
    "rate_control": ("base_faces_for", "level_count_for",),
    "stored_stream": ("StoredStream", "receive",),
})
