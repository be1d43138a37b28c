"""QSlim, then meshoptimizer's codec, then zstd over it, as its manual recommends.

The Python package has the codec and not the simplifier, so QSlim simplifies here too; libigl's is the better of both.
"""

import struct

import meshopt as library
import numpy as np
import zstandard

from npm_blender.core.mesh import TriMesh

from . import search
from .case import Case, Coded

NAME = "QSlim + meshopt + zstd"
BITS = tuple(range(8, 15))
LEVEL, VERSION = 3, 1
ZSTD_LEVEL = 22
HEADER = struct.Struct("<IIIB4f")  # vertices, indices, bytes of the indices, bits, origin and size of the box


def encode(mesh: TriMesh, bits: int) -> bytes:
    """The mesh on a lattice of so many bits of its box, in the order that the codec likes."""
    low = mesh.V.min(0)
    size = float((mesh.V.max(0) - low).max())
    lattice = np.zeros((len(mesh.V), 4), np.uint16)  # rows are multiples of four bytes
    lattice[:, :3] = np.rint((mesh.V - low) / size * (2**bits - 1))
    indices, remap, count = library.reorder_mesh(mesh.F.astype(np.uint32).reshape(-1), True, True)
    moved = np.zeros((count, 4), np.uint16)
    used = remap < count
    moved[remap[used]] = lattice[used]
    triangles = library.encode_index_buffer(indices)
    vertices = library.encode_vertex_buffer_level(moved, LEVEL, VERSION)
    head = HEADER.pack(count, len(indices), len(triangles), bits, *low, size)
    return head + zstandard.ZstdCompressor(level=ZSTD_LEVEL, write_content_size=True).compress(triangles + vertices)


def decode(data: bytes) -> TriMesh:
    """The mesh of `encode`."""
    count, indices, split, bits, *box = HEADER.unpack_from(data)
    body = zstandard.ZstdDecompressor().decompress(data[HEADER.size :])
    F = library.decode_index_buffer(body[:split], indices, 4)
    V = library.decode_vertex_buffer(body[split:], count, 8).view(np.uint16).reshape(count, 4)[:, :3]
    return TriMesh.from_arrays(V * (box[3] / (2**bits - 1)) + box[:3], F.astype(np.int32).reshape(-1, 3))


def at_bytes(case: Case, budgets: tuple[int, ...]) -> list[Coded | None]:
    """The best of all numbers of faces and bits."""
    codec = search.Codec(case.qslim, len(case.mesh.F), encode, decode, BITS)
    return search.choose(case, decode, search.candidates(case, codec, budgets))
