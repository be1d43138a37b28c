"""Mesh files in and out, by suffix: FORMATS below is the one table of them.

Every failure is a FileError (the file) or a MeshError (what is in it) of one line. To add a format, write a module beside
`ply` with a function from bytes to arrays and one back, and add a line to FORMATS; tests of what
is written run over the table, those of what is damaged have files of each kind.
"""
import os
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np

from ..errors import FileError, MeshError
from ..files import read_file, write_file
from ..mesh import TriMesh
from .draco import read_draco
from .obj import read_obj, write_obj
from .off import read_off, write_off
from .ply import read_ply, write_ply
from .scenes import read_scene, read_stl, write_glb, write_stl

Arrays: TypeAlias = tuple[np.ndarray, np.ndarray]  # V (n, 3) real, F (m, 3) whole numbers, both as the file has them


class Format(NamedTuple):
    """How files of one suffix are read and written.

    read: from a file's bytes and its path to V and F; it raises FileError, without the file's name, for what is not well formed.
    write: from V and F to a file's bytes, None where we cannot.
    """

    read: Callable[[bytes, Path], Arrays]
    write: Callable[[np.ndarray, np.ndarray], bytes] | None = None


def of_bytes(read: Callable[[bytes], Arrays]) -> Callable[[bytes, Path], Arrays]:
    """The reader of a format whose files stand alone: it needs no path."""
    return lambda data, path: read(data)


FORMATS = {
    ".ply": Format(of_bytes(read_ply), write_ply),
    ".obj": Format(of_bytes(read_obj), write_obj),
    ".off": Format(of_bytes(read_off), write_off),
    ".stl": Format(read_stl, write_stl),
    ".glb": Format(read_scene, write_glb),
    ".gltf": Format(read_scene),
    ".drc": Format(of_bytes(read_draco)),
}


def read_mesh(path: str | os.PathLike) -> TriMesh:
    """The triangle mesh in the file at `path`, in the file's units and axes.

    Polygons are triangulated. The meshes of a glTF scene are placed by their transforms and joined. STL and glTF
    repeat a vertex for each of its faces or seams: vertices at exactly the same place become one, as they do in the
    other formats. Unused vertices are kept. Raises FileError (missing, folder, empty, unknown suffix, cut short,
    damaged), MeshError (no faces, NaN) and DependencyError (.drc without DracoPy).

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from npm_blender.core.meshio import read_mesh
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "square.obj")
    ...     _ = path.write_text("v 0 0 0\\nv 1 0 0\\nv 1 1 0\\nv 0 1 0\\nf 1 2 3 4\\n")
    ...     read_mesh(path).F.tolist()  # a polygon of four corners is two triangles
    [[0, 1, 2], [0, 2, 3]]
    """
    path = Path(path)
    form = FORMATS.get(path.suffix.lower())
    if form is None:
        raise FileError(f"Expected a mesh file ({' '.join(FORMATS)}), found {path.name!r}; "
                        "convert it, or correct the suffix")
    data = read_file(path)
    try:
        V, F = form.read(data, path)
    except FileError as error:
        raise FileError(f"{path.name}: {error}") from None
    if len(V) and not len(F):
        raise MeshError(f"{path.name}: Expected a surface, found {len(V)} points without faces; "
                        "reconstruct a surface from them first")
    try:
        return TriMesh.from_arrays(V, F)
    except MeshError as error:
        raise MeshError(f"{path.name}: {error}") from None


def write_mesh(path: str | os.PathLike, mesh: TriMesh) -> None:
    """Write `mesh` to `path` atomically, in the format of its suffix: .ply (binary), .obj, .off, .stl (binary) or .glb.

    Coordinates are written as they are, as float32 (.obj and .off: nine digits). Raises FileError if the suffix is
    unknown or the file cannot be written.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from npm_blender.core.mesh import TriMesh
    >>> from npm_blender.core.meshio import write_mesh
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "face.obj")
    ...     write_mesh(path, TriMesh.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    ...     print(path.read_text().splitlines()[-1])
    f 1 2 3
    """
    path = Path(path)
    form = FORMATS.get(path.suffix.lower())
    if form is None or form.write is None:
        writable = [suffix for suffix, known in FORMATS.items() if known.write]
        raise FileError(f"Expected a name that ends in one of {' '.join(writable)}, found {path.name!r}; "
                        "correct the suffix")
    write_file(path, form.write(mesh.V, mesh.F))
