"""Levels of detail whose vertices lie on the input."""
from .lod_sequence import LodSequence, build_levels, build_lod

__all__ = [
    "LodSequence",
    "build_levels",
    "build_lod",
]
