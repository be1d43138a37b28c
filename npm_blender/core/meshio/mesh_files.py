"""Mesh files in and out: .ply .obj .stl .glb .gltf and, where DracoPy is installed, .drc (read only).

PLY and OBJ are read by this package; STL and glTF by trimesh, without its processing. Every failure is a FileError
(the file) or a MeshError (what is in it) of one line.
"""
import io
import os
from pathlib import Path

import numpy as np

from ..errors import DependencyError, FileError, MeshError
from ..files import read_file, write_file
from ..geometry import weld
from ..mesh import TriMesh
from .obj import read_obj, write_obj
from .ply import read_ply, write_ply


def read_mesh(path: str | os.PathLike) -> TriMesh:
    """The triangle mesh in the file at `path`, in the file's units and axes.

    Polygons are triangulated. The meshes of a glTF scene are placed by their transforms and joined. STL and glTF
    repeat a vertex for each of its faces or seams: vertices at exactly the same place become one, as they do in the
    other formats. Unused vertices are kept. Raises FileError (missing, folder, empty, unknown suffix, cut short,
    damaged), MeshError (no faces, NaN) and DependencyError (.drc without DracoPy).
    """
    path = Path(path)
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise FileError(f"Expected a mesh file ({' '.join(READERS)}), found {path.name!r}; "
                        "convert it, or correct the suffix")
    data = read_file(path)
    try:
        V, F = reader(data, path)
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
    """Write `mesh` to `path` atomically, in the format of its suffix: .ply (binary), .obj, .stl (binary) or .glb.

    Coordinates are written as they are, as float32 (.obj: nine digits). Raises FileError if the suffix is unknown or
    the file cannot be written.
    """
    path = Path(path)
    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        raise FileError(f"Expected a name that ends in one of {' '.join(WRITERS)}, found {path.name!r}; "
                        "correct the suffix")
    write_file(path, writer(mesh.V, mesh.F))


def _by_trimesh(data: bytes, path: Path):
    """The trimesh.Scene in `data`; whatever trimesh raises on damaged content becomes a FileError."""
    import trimesh

    kind = path.suffix.lower()[1:]
    try:
        # a .gltf names files beside it, which trimesh finds by its path
        source = {"file_obj": str(path)} if kind == "gltf" else {"file_obj": io.BytesIO(data), "file_type": kind}
        return trimesh.load_scene(**source, process=False)
    except Exception as error:  # a parser of foreign content raises whatever it trips over
        reason = " ".join(f"{type(error).__name__} {error}".split())[:100]
        raise FileError(f"Expected a whole {kind} file, found damaged or foreign content ({reason}); "
                        "export it again") from error


def _read_scene(data: bytes, path: Path) -> tuple[np.ndarray, np.ndarray]:
    scene = _by_trimesh(data, path)
    V, F, offset, points = [], [], 0, 0
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        mesh = scene.geometry[name]
        points += len(mesh.vertices)
        if getattr(mesh, "faces", None) is None:  # points and lines
            continue
        faces = np.asarray(mesh.faces).reshape(-1, 3)
        if len(faces) and (faces.min() < 0 or faces.max() >= len(mesh.vertices)):
            raise FileError("Expected faces to use the file's vertices, found others; the file is damaged")
        V.append(np.asarray(mesh.vertices) @ transform[:3, :3].T + transform[:3, 3])
        F.append((faces[:, ::-1] if np.linalg.det(transform[:3, :3]) < 0 else faces) + offset)
        offset += len(mesh.vertices)
    if not F and not points:
        raise FileError(f"Expected a {path.suffix.lower()[1:]} file with a mesh, found none in it; "
                        "it may be cut short or of another kind, export it again")
    if not F:
        return np.zeros((points, 3)), np.zeros((0, 3), np.int64)
    return _joined(np.concatenate(V), np.concatenate(F))


def _read_stl(data: bytes, path: Path) -> tuple[np.ndarray, np.ndarray]:
    if data[:6].lstrip().lower().startswith(b"solid") and b"facet" in data[:2000] and b"endsolid" not in data[-1000:]:
        raise FileError("Expected a text STL file to end with 'endsolid', found none; the file is cut short")
    return _read_scene(data, path)


def _joined(V: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    first, place = weld(V)
    return V[first], place[F]


def _read_draco(data: bytes, path: Path) -> tuple[np.ndarray, np.ndarray]:
    try:
        import DracoPy
    except ImportError:
        raise DependencyError("Expected the package DracoPy to read .drc files, found none; "
                              "run pip install DracoPy, or convert the file to .ply") from None
    try:
        mesh = DracoPy.decode(data)
    except Exception as error:  # DracoPy raises its own and plain exceptions
        raise FileError("Expected a whole drc file, found damaged or foreign content; export it again") from error
    faces = getattr(mesh, "faces", None)
    V = np.asarray(mesh.points, np.float64).reshape(-1, 3)
    return V, np.zeros((0, 3), np.int64) if faces is None else np.asarray(faces, np.int64).reshape(-1, 3)


def _write_by_trimesh(kind: str):
    def write(V: np.ndarray, F: np.ndarray) -> bytes:
        import trimesh

        return trimesh.Trimesh(V, F, process=False, validate=False).export(file_type=kind)

    return write


READERS = {".ply": lambda data, path: read_ply(data), ".obj": lambda data, path: read_obj(data), ".stl": _read_stl,
           ".glb": _read_scene, ".gltf": _read_scene, ".drc": _read_draco}
WRITERS = {".ply": write_ply, ".obj": write_obj, ".stl": _write_by_trimesh("stl"), ".glb": _write_by_trimesh("glb")}
