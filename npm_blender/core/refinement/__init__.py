"""What is sent, improved by gradient descent."""
from typing import TYPE_CHECKING

from ..lazy import lazy_exports

if TYPE_CHECKING:
    from .descent import Target
    from .offset_fit import OffsetFit
    from .offset_trace import traced_offsets
    from .refiner import Refiner

__all__ = [
    "OffsetFit",
    "Refiner",
    "Target",
    "traced_offsets",
]
__getattr__, __dir__ = lazy_exports(__name__, {
    "descent": ("Target",),
    "offset_fit": ("OffsetFit",),
    "offset_trace": ("traced_offsets",),
    "refiner": ("Refiner",),
})
