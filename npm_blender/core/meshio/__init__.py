"""Mesh files to arrays and back."""
from .mesh_files import read_mesh, write_mesh

__all__ = [
    "read_mesh",
    "write_mesh",
]
