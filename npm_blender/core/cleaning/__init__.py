"""Any triangles in, an oriented manifold out, with a report."""
from .cleanup import CleanReport, clean
from .inspection import MeshReport, inspect

__all__ = [
    "CleanReport",
    "MeshReport",
    "clean",
    "inspect",
]
