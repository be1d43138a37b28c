"""Wavefront OBJ: positions and polygons; texture coordinates, normals, groups and materials are passed over.

Read here, not by a general loader, because those cut the surface where texture coordinates change.
"""
import re

import numpy as np

from ..errors import FileError
from .triangulation import triangulate


def read_obj(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    """V (n, 3) float64, F (m, 3) int64 of the bytes of an OBJ file; all objects of the file in one mesh.

    Raises FileError, without the file's name, if a vertex or a face is not well formed.
    """
    lines = [line.strip() for line in data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").splitlines()]
    vertices = [line.split()[1:4] for line in lines if line[:2] in (b"v ", b"v\t")]
    faces = [line for line in lines if line[:2] in (b"f ", b"f\t")]
    if not vertices and not faces:
        raise FileError("Expected an OBJ file with lines 'v x y z' and 'f a b c', found neither")
    try:
        V = np.array(vertices, dtype="S").reshape(-1, 3).astype(np.float64)
    except ValueError:
        raise FileError("Expected vertex lines of an OBJ file to hold three numbers, found others") from None
    rows = [re.sub(rb"/\S*", b"", line).split()[1:] if b"/" in line else line.split()[1:] for line in faces]
    counts = np.array([len(row) for row in rows], np.int64)
    try:
        corners = np.array([c for row in rows for c in row], dtype="S").astype(np.int64)
    except ValueError:
        raise FileError("Expected face lines of an OBJ file to hold vertex numbers, found others") from None
    if (corners == 0).any():
        raise FileError("Expected vertex numbers of an OBJ file to start at 1, found 0")
    if (corners < 0).any():  # counted back from the last vertex before the face
        seen = np.cumsum([line[:2] in (b"v ", b"v\t") for line in lines])
        at_face = seen[[line[:2] in (b"f ", b"f\t") for line in lines]]
        corners = np.where(corners < 0, corners + np.repeat(at_face, counts), corners - 1)
    else:
        corners = corners - 1
    if len(corners) and (corners.min() < 0 or corners.max() >= len(V)):
        raise FileError(f"Expected faces of an OBJ file with {len(V)} vertices to use those, found vertex "
                        f"{corners.max() + 1 if corners.min() >= 0 else corners.min()}; the file may be cut short")
    return V, triangulate(V, corners, counts)


def write_obj(V: np.ndarray, F: np.ndarray) -> bytes:
    """An OBJ file of V (n, 3) and triangles F (m, 3), with nine significant digits."""
    vertices = "".join([f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in V.tolist()])
    faces = "".join([f"f {a} {b} {c}\n" for a, b, c in (F + 1).tolist()])
    return (vertices + faces).encode("ascii")
