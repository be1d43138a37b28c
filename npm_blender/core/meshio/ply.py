"""Stanford PLY: positions and polygons, ASCII and both binary orders; other elements and properties are passed over.

Read here because a general loader takes a text file that was cut short for a whole one, and fans concave polygons.
"""
from dataclasses import dataclass, field

import numpy as np

from ..errors import FileError
from ..jit import compiled
from .triangulation import triangulate

TYPES = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
         "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
         "double": "f8", "float64": "f8"}
CUT = "Expected {0} rows of {1} in a PLY file, found fewer; the file is cut short, export it again"


@dataclass
class Element:
    """One element of the header. properties: (name, item type, '' or the type of the list's count)."""

    name: str
    rows: int
    properties: list[tuple[str, str, str]] = field(default_factory=list)

    def index(self, *names: str) -> int:
        """Position of the first of `names` among the properties, or -1."""
        return next((i for i, (name, _, _) in enumerate(self.properties) if name in names), -1)


def read_ply(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    """V (n, 3) float64, F (m, 3) int64 of the bytes of a PLY file; F (0, 3) where it has no faces.

    Raises FileError, without the file's name, if the header is not a PLY header or rows are missing.
    """
    order, elements, body = _header(data)
    if order == "text":
        try:
            units = np.array(body.split(), dtype="S").astype(np.float64) if body.strip() else np.zeros(0)
        except ValueError:
            raise FileError("Expected numbers after the header of a PLY file, found other text") from None
    else:
        units = np.frombuffer(body, np.uint8)
    V, corners, counts, at = None, np.zeros(0, np.int64), np.zeros(0, np.int64), 0
    for element in elements:
        # a scalar takes one unit of a text file and `itemsize` units, bytes, of a binary one
        sizes = [1 if order == "text" else np.dtype(t).itemsize for _, t, _ in element.properties]
        counters = [0 if not c else 1 if order == "text" else np.dtype(c).itemsize for _, _, c in element.properties]
        axes = [element.index(name) for name in "xyz"]
        polygon = element.index("vertex_indices", "vertex_index")
        wanted = axes if element.name == "vertex" else [polygon]
        if element.rows > len(units) - at:  # each row takes at least one unit: no memory for counts that lie
            raise FileError(CUT.format(element.rows, element.name))
        starts, lengths, at = _rows(units, at, element.rows, np.array(sizes, np.int64), np.array(counters, np.int64),
                                    np.array(wanted, np.int64), order == ">")
        if at < 0:
            raise FileError(CUT.format(element.rows, element.name))
        if element.name == "vertex":
            if min(axes) < 0:
                raise FileError("Expected the vertices of a PLY file to have x, y and z, found none")
            V = np.stack([_values(units, starts[:, i], element.properties[axis][1], order)
                          for i, axis in enumerate(axes)], 1).astype(np.float64)
        elif element.name == "face" and polygon >= 0:
            counts = lengths[:, 0]
            kind = element.properties[polygon][1]
            step = sizes[polygon]
            within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
            corners = _values(units, np.repeat(starts[:, 0], counts) + step * within, kind, order).astype(np.int64)
    if V is None:
        raise FileError("Expected a PLY file with an element vertex, found none")
    if len(corners) and (corners.min() < 0 or corners.max() >= len(V)):
        raise FileError(f"Expected faces of a PLY file to use its vertices 0..{len(V) - 1}, found "
                        f"{corners.min()}..{corners.max()}; the file is damaged")
    return V, triangulate(V, corners, counts)


def write_ply(V: np.ndarray, F: np.ndarray) -> bytes:
    """A binary little-endian PLY file of V (n, 3) and triangles F (m, 3).

    Positions are float; double where float would round by more than 1e-6 of the mesh's extent (far from the origin).
    """
    rounding = np.abs(V - V.astype(np.float32)).max(initial=0)
    kind, dtype = ("float", "<f4") if rounding <= 1e-6 * np.ptp(V, axis=0).max() else ("double", "<f8")
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(V)}\n"
              f"property {kind} x\nproperty {kind} y\nproperty {kind} z\n"
              f"element face {len(F)}\nproperty list uchar int vertex_indices\nend_header\n")
    faces = np.zeros(len(F), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, F
    return header.encode("ascii") + V.astype(dtype).tobytes() + faces.tobytes()


def _header(data: bytes) -> tuple[str, list[Element], bytes]:
    """Byte order ('text', '<' or '>'), elements, and what follows the header."""
    if not data.startswith(b"ply"):
        raise FileError("Expected a PLY file that starts with 'ply', found other content")
    end = data.find(b"end_header", 0, 100_000)
    newline = data.find(b"\n", end)
    if end < 0 or newline < 0:
        raise FileError("Expected the header of a PLY file to end with 'end_header', found no such line")
    order, elements = None, []
    try:
        for line in data[:end].decode("latin-1").splitlines()[1:]:
            word = line.split()
            if word[:1] == ["format"]:
                order = {"ascii": "text", "binary_little_endian": "<", "binary_big_endian": ">"}[word[1]]
            elif word[:1] == ["element"]:
                elements.append(Element(word[1], int(word[2])))
            elif word[:2] == ["property", "list"]:
                elements[-1].properties.append((word[4], TYPES[word[3]], TYPES[word[2]]))
            elif word[:1] == ["property"]:
                elements[-1].properties.append((word[2], TYPES[word[1]], ""))
    except (KeyError, IndexError, ValueError):
        raise FileError(f"Expected a line of a PLY header, found {line[:60]!r}") from None
    if order is None or any(e.rows < 0 for e in elements):
        raise FileError("Expected the header of a PLY file to name its format and counts, found none or negative ones")
    return order, elements, data[newline + 1:]


def _values(units: np.ndarray, at: np.ndarray, kind: str, order: str) -> np.ndarray:
    """The scalars of type `kind` that start at units `at`, in an array of at's shape."""
    if order == "text":
        return units[at]
    size = np.dtype(kind).itemsize
    return units[at[:, None] + np.arange(size)].reshape(-1).view(order + kind)


@compiled(allocates=True)
def _rows(units, at, rows, sizes, counters, wanted, big):
    """Pass over `rows` rows: starts and lengths (rows, len(wanted)) of the wanted properties, and the end or -1."""
    starts, lengths = np.zeros((rows, len(wanted)), np.int64), np.zeros((rows, len(wanted)), np.int64)
    end = len(units)
    for r in range(rows):
        for p in range(len(sizes)):
            count = np.int64(1)
            size = counters[p]
            if size:
                if at + size > end:
                    return starts, lengths, -1
                count = np.int64(units[at])
                for b in range(1, size):  # text has counters of size 1
                    byte = np.int64(units[at + b])
                    count = count * 256 + byte if big else count + (byte << (8 * b))
                at += size
            if count < 0 or at + count * sizes[p] > end:
                return starts, lengths, -1
            for w in range(len(wanted)):
                if wanted[w] == p:
                    starts[r, w], lengths[r, w] = at, count
            at += count * sizes[p]
    return starts, lengths, at
