"""Object File Format (.off), text: positions and polygons; colours, normals and texture coordinates are passed over.

Read here because a general loader takes a file that was cut short for a whole one, and fans concave polygons. The format is
that of Geomview's manual, with one line for each vertex and each face.
"""
import re

import numpy as np

from ..errors import FileError
from .triangulation import triangulate

HEADER = re.compile(rb"(ST)?(C)?(N)?(4)?(n)?OFF(.*)", re.DOTALL)  # the letters name what a vertex has beside x, y and z
COUNTS = re.compile(rb"\s*(\d{1,18})\s+(\d{1,18})(\s+\d+)?\s*")  # vertices, faces, edges (nobody needs those)
CUT = "Expected {0} lines of {1} in an OFF file, found {2}; the file is cut short, export it again"


def read_off(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    """V (n, 3) float64, F (m, 3) int64 of the bytes of an OFF file; F (0, 3) where it has no faces.

    The word OFF may be missing. Raises FileError, without the file's name, if the file is binary or has four or n
    dimensions, if lines are missing or too many, or if one is not well formed.
    """
    lines = [line for line in (line.partition(b"#")[0].strip() for line in data.splitlines()) if line]
    if not lines:
        raise FileError("Expected an OFF file, found comments alone")
    least, most, at = 3, 3, 0  # columns of a vertex; the line of the counts
    header = HEADER.fullmatch(lines[0])
    if header:
        texture, colour, normal, four, many, rest = header.groups()
        if four or many:
            raise FileError(f"Expected an OFF file of three dimensions, found {lines[0][:20].decode('latin-1')!r}; "
                            "export it as OFF")
        if rest.split()[:1] == [b"BINARY"]:
            raise FileError("Expected an OFF file of text, found a binary one; export it as text")
        least += 2 * bool(texture) + 3 * bool(colour) + 3 * bool(normal)
        most = least + bool(colour)  # colours come with opacity or without
        if rest:
            lines[0] = rest
        else:
            at = 1
    found = COUNTS.fullmatch(lines[at]) if at < len(lines) else None
    if not found:
        raise FileError("Expected an OFF file to start with 'OFF' and the numbers of its vertices, faces and edges, "
                        "found other content")
    n, m = int(found[1]), int(found[2])
    rows = lines[at + 1:]  # no memory for counts that lie: they only cut these
    if n > len(rows):
        raise FileError(CUT.format(n, "vertices", len(rows)))
    if m > len(rows) - n:
        raise FileError(CUT.format(m, "faces", len(rows) - n))
    if len(rows) > n + m:
        raise FileError(f"Expected {n} vertices and {m} faces in an OFF file, a line each, found {len(rows)} lines; "
                        "correct the counts, or export it again")
    V = _positions(rows[:n], least, most)
    corners, counts = _polygons(rows[n:])
    if len(corners) and (corners.min() < 0 or corners.max() >= n):
        raise FileError(f"Expected faces of an OFF file to use its vertices 0..{n - 1}, found "
                        f"{corners.min()}..{corners.max()}; the file is damaged")
    return V, triangulate(V, corners, counts)


def write_off(V: np.ndarray, F: np.ndarray) -> bytes:
    """An OFF file of V (n, 3) and triangles F (m, 3), with nine significant digits; edges are not counted."""
    vertices = "".join([f"{x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in V.tolist()])
    faces = "".join([f"3 {a} {b} {c}\n" for a, b, c in F.tolist()])
    return f"OFF\n{len(V)} {len(F)} 0\n{vertices}{faces}".encode("ascii")


def _positions(rows: list[bytes], least: int, most: int) -> np.ndarray:
    """V (n, 3) float64 of vertex lines, each of `least` to `most` columns, of which the first three count."""
    words = [row.split() for row in rows]
    other = next((len(row) for row in words if not least <= len(row) <= most), None)
    if other is not None:
        wanted = f"{least} or {most}" if most > least else f"{least}"
        raise FileError(f"Expected vertex lines of an OFF file with this header to hold {wanted} numbers, found {other}; "
                        "correct the header, or export it again")
    try:
        return np.array([float(x) for row in words for x in row[:3]], np.float64).reshape(-1, 3)
    except ValueError:
        raise FileError("Expected vertex lines of an OFF file to hold numbers, found others; "
                        "the file is damaged") from None


def _polygons(rows: list[bytes]) -> tuple[np.ndarray, np.ndarray]:
    """Corners (sum of counts,) int64 and counts (m,) int64 of face lines; colours behind the corners are ignored."""
    corners: list[int] = []
    counts: list[int] = []
    try:
        for row in rows:
            words = row.split()
            count = int(words[0])
            if not 0 <= count < len(words):
                raise FileError(f"Expected {count} corners in a face line of an OFF file, found {len(words) - 1} numbers; "
                                "the file is damaged or cut short")
            corners.extend([int(word) for word in words[1:count + 1]])
            counts.append(count)
        return np.array(corners, np.int64), np.array(counts, np.int64)
    except (ValueError, OverflowError):
        raise FileError("Expected face lines of an OFF file to hold vertex numbers, found others; "
                        "the file is damaged") from None
