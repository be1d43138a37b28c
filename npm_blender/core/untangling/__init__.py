"""Vertices moved over the surface until no face is folded over."""
from .rounds import untangle

__all__ = [
    "untangle",
]
