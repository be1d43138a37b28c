"""Mesh files to arrays and back."""
from .mesh_files import FORMATS, read_mesh, write_mesh

__all__ = [
    "FORMATS",
    "read_mesh",
    "write_mesh",
]
