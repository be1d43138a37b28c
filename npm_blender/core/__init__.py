"""Neural progressive meshes, without Blender: arrays in, bytes out, and back.

    from npm_blender.core import TriMesh, compress, open_stream

    data = compress(TriMesh.from_arrays(V, F)).data          # bytes
    mesh = open_stream(data).decode(level=2)                 # of these, or of any prefix that holds the base

The rooms, from what comes first to what stands on it: `mesh`, `geometry`, `meshio`, `cleaning`, `parameterization`,
`decimation`, `untangling`, `levels`, `displacement`, `fitting`, `network`, `bitstream`, `codec`, `evaluation`. Each is one
sentence and its exports (docs/architecture.md is the tour). Nothing here imports bpy; torch is imported only where a gradient
is needed.
"""
from typing import TYPE_CHECKING

from .lazy import lazy_exports

if TYPE_CHECKING:
    from .codec import compress, open_stream
    from .errors import (
        Cancelled,
        DependencyError,
        FileError,
        MeshError,
        NpmError,
        SettingsError,
        StreamError,
        WeightsError,
    )
    from .evaluation import evaluate
    from .levels import build_lod
    from .mesh import TriMesh
    from .meshio import read_mesh, write_mesh
    from .settings import CompressSettings, LodSettings

__all__ = [
    "Cancelled",
    "CompressSettings",
    "DependencyError",
    "FileError",
    "LodSettings",
    "MeshError",
    "NpmError",
    "SettingsError",
    "StreamError",
    "TriMesh",
    "WeightsError",
    "build_lod",
    "compress",
    "evaluate",
    "open_stream",
    "read_mesh",
    "write_mesh",
]
__getattr__, __dir__ = lazy_exports(__name__, {
    "codec": ("compress", "open_stream"),
    "errors": ("Cancelled", "DependencyError", "FileError", "MeshError", "NpmError", "SettingsError", "StreamError",
               "WeightsError"),
    "evaluation": ("evaluate",),
    "levels": ("build_lod",),
    "mesh": ("TriMesh",),
    "meshio": ("read_mesh", "write_mesh"),
    "settings": ("CompressSettings", "LodSettings"),
})
