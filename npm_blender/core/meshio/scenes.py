"""STL and glTF, by the package trimesh without its processing: many meshes in a file, vertices repeated at seams."""
import io
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FileError
from ..geometry import weld


def read_scene(data: bytes, path: Path) -> tuple[np.ndarray, np.ndarray]:
    """V (n, 3), F (m, 3) of all meshes of a glTF or STL file, each placed by its transform, coincident vertices made one.

    data: the file's bytes; path: where it lies, for the files that a .gltf names beside it. Raises FileError, without the file's
    name, for damaged content.
    """
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
    P = np.concatenate(V)
    first, place = weld(P)
    return P[first], place[np.concatenate(F)]


def read_stl(data: bytes, path: Path) -> tuple[np.ndarray, np.ndarray]:
    """As `read_scene`; a text file that was cut short is refused, which trimesh would take for a whole one."""
    if data[:6].lstrip().lower().startswith(b"solid") and b"facet" in data[:2000] and b"endsolid" not in data[-1000:]:
        raise FileError("Expected a text STL file to end with 'endsolid', found none; the file is cut short")
    return read_scene(data, path)


def write_stl(V: np.ndarray, F: np.ndarray) -> bytes:
    """A binary STL file of V (n, 3) and triangles F (m, 3), as float32."""
    return _written(V, F, "stl")


def write_glb(V: np.ndarray, F: np.ndarray) -> bytes:
    """A binary glTF file of V (n, 3) and triangles F (m, 3), as float32."""
    return _written(V, F, "glb")


def _written(V: np.ndarray, F: np.ndarray, kind: str) -> bytes:
    import trimesh

    data: Any = trimesh.Trimesh(V, F, process=False, validate=False).export(file_type=kind)
    return data


def _by_trimesh(data: bytes, path: Path) -> Any:
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
