"""How far a decoded mesh is from its source, at how many bytes."""
from typing import TYPE_CHECKING

from ..lazy import lazy_exports

if TYPE_CHECKING:
    from .metrics import Metrics, Original, compression_ratio, evaluate
    from .prefix_errors import PrefixErrors, measure_prefixes, prefix_errors_from_text, thinned

__all__ = [
    "Metrics",
    "Original",
    "PrefixErrors",
    "compression_ratio",
    "evaluate",
    "measure_prefixes",
    "prefix_errors_from_text",
    "thinned",
]
__getattr__, __dir__ = lazy_exports(__name__, {
    "metrics": ("Metrics", "Original", "compression_ratio", "evaluate",),
    "prefix_errors": ("PrefixErrors", "measure_prefixes", "prefix_errors_from_text", "thinned"),
})
