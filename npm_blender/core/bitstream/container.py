"""The `.npmesh` container: header, base mesh, features. docs/format.md is its specification.

Every prefix that holds the base mesh is a valid stream of fewer features.
"""
import struct
from typing import NamedTuple
from zlib import crc32

import numpy as np

from ..errors import StreamError
from ..mesh import hierarchy, opposite_halfedges
from .base_positions import decode_positions, encode_positions
from .chunks import CRC_BYTES, arrived, chunk_ends, framed_size, with_checksums
from .connectivity import decode_connectivity, encode_connectivity
from .displacements import around, decode_displacements
from .header import (
    MAX_LEVEL_FACES,
    MAX_NUMBERS,
    DisplacedCoding,
    DisplacedNumbers,
    Header,
    LatentCoding,
    LatentFeatures,
    ParsedStream,
    check_header,
)
from .packet_encoder import encode_packets
from .packets import Features, read_packets
from .significance import faces_of
from .varint import read_varint, write_varint

MAGIC = b"\x8aNPM"
VERSION = 4                     # 1 to 3 came before the first release
_MAX_BASE_BYTES = 1 << 26       # connectivity and positions of the largest base mesh stay far below
_CRC_BYTES = 4                  # behind the base mesh
_LATENTS, _WIDE, _FLAGS = 1, 2, 3  # flags: the features are latents; the corner is float64


class EncodedBase(NamedTuple):
    """A coded base mesh: faces F0 (m0, 3) in `canonical_order`; bytes of its connectivity and of its positions.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import EncodedBase, encode_connectivity, encode_positions
    >>> V0, F0 = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]), np.array([[0, 1, 2], [3, 1, 0]])
    >>> base = EncodedBase(F0, encode_connectivity(F0), encode_positions(V0, F0))
    >>> len(base.connectivity)
    5
    """

    F0: np.ndarray
    connectivity: bytes
    positions: bytes


def encode_base(grid: np.ndarray, F0: np.ndarray, connectivity: bytes | None = None) -> EncodedBase:
    """Code a base mesh: grid (n0, 3), lattice positions; F0 (m0, 3) in `canonical_order`.

    connectivity: the bytes of F0, where they are at hand (`order_connectivity`). Raises MeshError if something is out of
    range, or if F0 is in another order.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import encode_base
    >>> base = encode_base(np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]), np.array([[0, 1, 2], [3, 1, 0]]))
    >>> len(base.connectivity)
    5
    """
    return EncodedBase(F0, encode_connectivity(F0) if connectivity is None else connectivity, encode_positions(grid, F0))


def _body(header: Header, base: EncodedBase) -> bytes:
    """Header and base mesh, with their checksums."""
    coding, place = header.coding, np.array(header.low)
    wide = bool((place.astype(np.float32) != place).any())
    if isinstance(coding, LatentCoding):
        latent, smooth, name = True, 0, coding.model_id.encode("ascii")
        said = [bytes([len(name)]), name, coding.weights_hash, bytes([coding.channels]), np.array(coding.steps, "<f4").tobytes()]
    else:
        latent, smooth = False, coding.smooth
        said = [write_varint(coding.step), bytes([coding.growth, coding.stages]), write_varint(coding.payload),
                bytes(coding.ends)]
    head = b"".join([
        MAGIC, bytes([VERSION, latent * _LATENTS + wide * _WIDE, header.position_bits, header.levels << 4 | smooth]),
        *map(write_varint, (header.total_features, header.source_faces, header.source_vertices)),
        place.astype("<f8" if wide else "<f4").tobytes(), struct.pack("<f", header.size), *said,
        *map(write_varint, (len(base.connectivity), len(base.positions)))])
    body = head + (crc32(head) & 0xFFFF).to_bytes(2, "big") + base.connectivity + base.positions
    return body + crc32(body).to_bytes(_CRC_BYTES, "big")


def write_displaced(header: Header, base: EncodedBase, payload: bytes) -> bytes:
    """A whole stream of a displaced surface; payload: from `encode_displacements`, as long as `header.coding` says.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import *  # all of the room
    >>> F0 = np.array([[0, 1, 2], [3, 1, 0]])
    >>> base = encode_base(np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]), F0)
    >>> header = Header(0, 8, 0, 2, 4, (0, 0, 0), 1.0, DisplacedCoding(0, 0, 22, 0, 0))
    >>> read_stream(write_displaced(header, base, b"")).grid.tolist()
    [[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]
    """
    body = _body(header, base)
    return body + with_checksums(payload, int.from_bytes(body[-_CRC_BYTES:], "big") & 0xFFFF)


def displaced_size(header: Header, base: EncodedBase, payload: int) -> int:
    """Bytes of a whole stream whose payload has so many.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import *  # all of the room
    >>> F0 = np.array([[0, 1, 2], [3, 1, 0]])
    >>> base = encode_base(np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]), F0)
    >>> header = Header(0, 8, 0, 2, 4, (0, 0, 0), 1.0, DisplacedCoding(0, 0, 22, 0, 0))
    >>> displaced_size(header, base, payload=0) == len(write_displaced(header, base, b""))
    True
    """
    return len(_body(header, base)) + framed_size(payload, payload)


def write_latents(header: Header, base: EncodedBase, features: LatentFeatures) -> bytes:
    """A whole stream of latents, features in order of importance, header.total_features of them. Raises StreamError where the
    shapes do not fit, a face comes twice in a level, or something is out of range.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import *  # all of the room
    >>> F0 = np.array([[0, 1, 2], [3, 1, 0]])
    >>> base = encode_base(np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]), F0)
    >>> header = Header(1, 8, 1, 2, 4, (0, 0, 0), 1.0, LatentCoding("demo", bytes(8), (0.5,), channels=2))
    >>> data = write_latents(header, base, LatentFeatures(np.array([0]), np.array([1]), np.array([[3, -4]])))
    >>> read_stream(data).details.value.tolist()
    [[3, -4]]
    """
    assert isinstance(header.coding, LatentCoding)
    if features.value.shape != (header.total_features, header.coding.channels):
        raise StreamError(f"Expected {header.total_features} features of {header.coding.channels} numbers, "
                          f"found {features.value.shape}; give level, face and value of equal lengths")
    _check_size(len(base.F0), header)
    faces = faces_of(base.F0, header.levels)
    body = _body(header, base)
    packets = encode_packets(faces, Features(features.level, features.face, features.value),
                             int.from_bytes(body[-_CRC_BYTES:], "big") & 0xFFFF)
    return body + b"".join(packets)


def read_stream(data: bytes, strict: bool = False) -> ParsedStream:
    """Read a stream, or any prefix of one past its base mesh.

    Raises StreamError if the data are no stream, from another version, damaged in header or base mesh, or end before
    the base mesh does. Damage in the features ends the reading there: see ParsedStream.corrupt, or StreamError if `strict`.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import DisplacedCoding, Header, encode_base, read_stream, write_displaced
    >>> base = encode_base(np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]), np.array([[0, 1, 2], [3, 1, 0]]))
    >>> data = write_displaced(Header(0, 8, 0, 2, 4, (0, 0, 0), 1.0, DisplacedCoding(0, 0, 22, 0, 0)), base, b"")
    >>> read = read_stream(data)
    >>> len(read.F0), read.truncated, read.base_bytes == len(data)
    (2, False, True)
    """
    data = bytes(data)
    header, at, connectivity_bytes, position_bytes = _read_header(data)
    middle = at + connectivity_bytes
    end = middle + position_bytes
    start = end + _CRC_BYTES
    if len(data) < start:
        raise StreamError(f"Expected at least {start} bytes (the base mesh), found {len(data)}; "
                          "get the rest of the file")
    crc = crc32(data[:end])
    if crc != int.from_bytes(data[end:start], "big"):
        raise StreamError("Expected an intact base mesh, found a wrong checksum; the file is corrupted, get it again")
    F0 = decode_connectivity(data[at:middle])
    _check_size(len(F0), header)
    grid = decode_positions(data[middle:end], F0)
    read = _read_latents if isinstance(header.coding, LatentCoding) else _read_displaced
    parsed = read(data, start, header, grid, F0, crc & 0xFFFF)
    if strict and parsed.corrupt:
        raise StreamError(parsed.corrupt)
    return parsed


def _read_latents(data: bytes, start: int, header: Header, grid: np.ndarray, F0: np.ndarray, crc: int) -> ParsedStream:
    assert isinstance(header.coding, LatentCoding)
    faces = faces_of(F0, header.levels)
    packets = read_packets(data, start, faces, header.coding.channels, header.total_features, crc)
    return ParsedStream(header, grid, F0, LatentFeatures(packets.level, packets.face, packets.value),
                        (packets.features, packets.bytes), start, packets.truncated, packets.corrupt)


def _read_displaced(data: bytes, start: int, header: Header, grid: np.ndarray, F0: np.ndarray, crc: int) -> ParsedStream:
    coding = header.coding
    assert isinstance(coding, DisplacedCoding)
    found = arrived(data, start, coding.payload, crc)
    count = coding.stages * _finest_vertices(F0, len(grid), header.levels)
    if count > MAX_NUMBERS:
        raise StreamError(f"Expected at most {MAX_NUMBERS} numbers, found {count}; the file is corrupted")
    levels = hierarchy(F0, len(grid), header.levels)
    first = np.array([0, *(level.n for level in levels)], np.int64)
    coded = decode_displacements(found.payload, coding.stages, around(levels), first)
    # bytes of the payload, and with the checksums between them
    ends = np.array(chunk_ends(coding.payload), np.int64)
    at = start + coded.ends + CRC_BYTES * np.searchsorted(ends, coded.ends)
    whole = coded.numbers == header.total_features
    if whole and coded.numbers and len(found.payload) == coding.payload:
        at[-1] = len(data)
    wrong = found.corrupt
    if not wrong and len(found.payload) == coding.payload and not whole:
        wrong = f"Expected {header.total_features} numbers, found {coded.numbers}"
    arrived_numbers = np.minimum(np.arange(len(at)) * coded.group, coded.numbers)
    return ParsedStream(header, grid, F0, DisplacedNumbers(coded.table, coded.coded), (arrived_numbers, at), start,
                        found.truncated, wrong)


def _finest_vertices(F0: np.ndarray, n: int, levels: int) -> int:
    """Vertices of the finest level over F0 (m0, 3) with n vertices, before any level is made."""
    opposite, m = opposite_halfedges(F0), len(F0)
    edges = (3 * m + np.count_nonzero(opposite == np.arange(3 * m))) // 2
    for _ in range(levels):
        n, edges, m = n + edges, 2 * edges + 3 * m, 4 * m
    return int(n)


def _check_size(faces: int, header: Header) -> None:
    total = faces * (4 ** (header.levels + 1) - 1) // 3
    if total > 4 * MAX_LEVEL_FACES:
        raise StreamError(f"Expected at most {4 * MAX_LEVEL_FACES} faces in all levels, found {total}; "
                          "use fewer base faces or levels")


def _read_header(data: bytes) -> tuple[Header, int, int, int]:
    """Header, offset of the connectivity, bytes of connectivity, bytes of positions."""
    if not data:
        raise StreamError("Expected an .npmesh stream, found no data; the file is empty")
    if not data.startswith(MAGIC[:len(data)]):
        raise StreamError(f"Expected an .npmesh stream, found {data[:4]!r} at its start; this is another kind of file")
    if len(data) > len(MAGIC) and data[len(MAGIC)] != VERSION:
        found = data[len(MAGIC)]
        what = "update the extension" if found > VERSION else "it was made before the first release, compress the original again"
        raise StreamError(f"Expected format version {VERSION}, found {found}; {what}")
    try:
        return _header_fields(data)
    except EOFError:
        raise StreamError(f"Expected a whole header, found the end of the file after {len(data)} bytes; "
                          "get the rest of the file") from None


def _header_fields(data: bytes) -> tuple[Header, int, int, int]:
    """As `_read_header`. Raises EOFError if the data end inside the header."""
    at = len(MAGIC)

    def take(count: int) -> bytes:
        nonlocal at
        if at + count > len(data):
            raise EOFError
        at += count
        return data[at - count:at]

    def number() -> int:
        nonlocal at
        value, at = read_varint(data, at)
        return value

    _, flags, bits, shape = take(4)
    counts = number(), number(), number()
    low = np.frombuffer(take(24 if flags & _WIDE else 12), "<f8" if flags & _WIDE else "<f4").astype(np.float64)
    (size,) = struct.unpack("<f", take(4))
    levels = shape >> 4
    latent: tuple = ()
    displaced: tuple = ()
    if flags & _LATENTS:
        (length,) = take(1)
        latent = take(length).decode("ascii", "replace"), take(8), take(1)[0], np.frombuffer(take(4 * levels), "<f4")
    else:
        displaced = shape & 15, number(), *take(2), number(), tuple(take(levels))
    sizes = number(), number()
    head = at
    if int.from_bytes(take(2), "big") != crc32(data[:head]) & 0xFFFF:
        raise StreamError("Expected an intact header, found a wrong checksum; the file is corrupted, get it again")
    check_header(flags <= _FLAGS, "known flags", flags)
    check_header(sum(sizes) <= _MAX_BASE_BYTES, f"a base mesh of at most {_MAX_BASE_BYTES} bytes", sum(sizes))
    if latent:
        name, digest, channels, steps = latent
        coding: DisplacedCoding | LatentCoding = LatentCoding(name, digest, tuple(map(float, steps)), channels)
    else:
        coding = DisplacedCoding(*displaced)
    x, y, z = map(float, low)
    return Header(levels, bits, *counts, (x, y, z), size, coding), at, *sizes
