"""The `.npmesh` container: header, base mesh, packets of features. docs/format.md is its specification.

Every prefix that holds the base mesh is a valid stream of fewer features.
"""
import struct
from dataclasses import replace
from typing import NamedTuple
from zlib import crc32

import numpy as np

from ..errors import StreamError
from .base_positions import decode_positions, encode_positions
from .connectivity import decode_connectivity, encode_connectivity
from .header import MAX_LEVEL_FACES, MAX_PASSES, Header, ParsedStream, check_header
from .packet_encoder import PacketEncoder, with_checksums
from .packets import CRC_BYTES as PACKET_CRC_BYTES
from .packets import Features, read_packets
from .significance import faces_of
from .varint import read_varint, write_varint

MAGIC = b"\x8aNPM"
VERSION = 3                     # 1 has no offsets, 2 no batches of several packets
_MAX_BASE_BYTES = 1 << 26       # connectivity and positions of the largest base mesh stay far below
_CRC_BYTES = 4                  # behind the base mesh
_PLACE = struct.Struct("<4d")


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


def encode_base(V0_ints: np.ndarray, F0: np.ndarray, connectivity: bytes | None = None) -> EncodedBase:
    """Code a base mesh: V0_ints (n0, 3), lattice positions (`quantize_positions`); F0 (m0, 3) in `canonical_order`.

    connectivity: the bytes of F0, where they are at hand (`order_connectivity`). Raises MeshError if something is out of
    range, or if F0 is in another order.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import encode_base
    >>> base = encode_base(np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]), np.array([[0, 1, 2], [3, 1, 0]]))
    >>> len(base.connectivity)
    5
    """
    return EncodedBase(F0, encode_connectivity(F0) if connectivity is None else connectivity, encode_positions(V0_ints, F0))


class StreamWriter:
    """Streams of the first k of some features over one base, for any k.

    The base is coded once, and so is each batch of packets that several k have in common (`PacketEncoder`).

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import Header, StreamWriter, encode_base, read_stream
    >>> base = encode_base(np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]), np.array([[0, 1, 2], [3, 1, 0]]))
    >>> header = Header("demo", bytes(8), 1, 10, (0.5,), 2, 2, 4, (0, 0, 0), 1.0)
    >>> writer = StreamWriter(header, base, np.zeros(2, int), np.arange(2), np.ones((2, 8), int))
    >>> [read_stream(writer.stream(k)).header.total_features for k in (0, 1, 2)]
    [0, 1, 2]
    >>> writer.size(1) == len(writer.stream(1))
    True
    """

    def __init__(self, header: Header, base: EncodedBase, group: np.ndarray, face: np.ndarray, value: np.ndarray) -> None:
        """group (k,), face (k,), value (k, channels): features in order of importance, k = header.total_features.

        Raises StreamError if something is out of range.
        """
        value = np.asarray(value)
        if value.shape != (header.total_features, header.channels) or len(group) != len(value) or len(face) != len(value):
            raise StreamError(f"Expected {header.total_features} features of {header.channels} numbers, "
                              f"found {value.shape}; give group, face and value of equal lengths")
        _check_size(len(base.F0), header.levels, header.passes)
        self._header, self._base = header, base
        faces = faces_of(base.F0, header.levels, header.passes)
        self._encoder = PacketEncoder(faces, Features(group, face, value))

    def size(self, count: int | None = None) -> int:
        """Bytes of the stream of the first `count` features, None for all."""
        packets = self._encoder.packets(count)
        return len(self._body(count)) + _CRC_BYTES + sum(map(len, packets)) + PACKET_CRC_BYTES * len(packets)

    def stream(self, count: int | None = None) -> bytes:
        """The stream of the first `count` features, None for all."""
        body = self._body(count)
        crc = crc32(body)
        return b"".join([body, crc.to_bytes(_CRC_BYTES, "big"), *with_checksums(self._encoder.packets(count), crc & 0xFFFF)])

    def _body(self, count: int | None) -> bytes:
        """Header and base mesh."""
        header = self._header if count is None else replace(self._header, total_features=count)
        return _head(header, self._base) + self._base.connectivity + self._base.positions


def _head(header: Header, base: EncodedBase) -> bytes:
    """The header with its checksum."""
    name = header.model_id.encode("ascii")
    head = b"".join([
        MAGIC, bytes([VERSION, len(name)]), name, header.weights_hash,
        bytes([header.levels - 1 | header.channels - 1 << 3, header.position_bits]),
        bytes([header.passes]), np.array(header.feature_steps, dtype="<f4").tobytes(),
        *map(write_varint, (header.total_features, header.source_faces, header.source_vertices)),
        _PLACE.pack(*header.centre, header.size), *map(write_varint, (len(base.connectivity), len(base.positions)))])
    return head + (crc32(head) & 0xFFFF).to_bytes(2, "big")


def write_stream(header: Header, V0_ints: np.ndarray, F0: np.ndarray, group: np.ndarray, face: np.ndarray,
                 value: np.ndarray) -> bytes:
    """A whole stream; the format is ours, docs/format.md is its specification.

    V0_ints (n0, 3): lattice positions (`quantize_positions`); F0 (m0, 3) in `canonical_order`; group (k,), face (k,),
    value (k, channels): features in order of importance, k = header.total_features.
    Raises StreamError or MeshError if something is out of range, MeshError if F0 is in another order.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import Header, write_stream
    >>> V0, F0 = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]), np.array([[0, 1, 2], [3, 1, 0]])
    >>> header = Header("demo", bytes(8), 1, 10, (0.5,), 1, 2, 4, (0, 0, 0), 1.0)
    >>> data = write_stream(header, V0, F0, [0], [1], np.ones((1, 8), int))
    >>> data[1:4]
    b'NPM'
    """
    return StreamWriter(header, encode_base(V0_ints, F0), group, face, value).stream()


def read_stream(data: bytes, strict: bool = False) -> ParsedStream:
    """Read a stream, or any prefix of one past its base mesh.

    Raises StreamError if the data are no stream, from a newer version, damaged in header or base mesh, or end before
    the base mesh does. Damage in the packets ends the reading there: see ParsedStream.corrupt, or StreamError if `strict`.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import Header, read_stream, write_stream
    >>> V0, F0 = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]), np.array([[0, 1, 2], [3, 1, 0]])
    >>> header = Header("demo", bytes(8), 1, 10, (0.5,), 1, 2, 4, (0, 0, 0), 1.0)
    >>> data = write_stream(header, V0, F0, [0], [1], np.ones((1, 8), int))
    >>> whole, cut = read_stream(data), read_stream(data[:-1])
    >>> (whole.V0 * 2**10).tolist() == V0.tolist(), whole.face.tolist(), cut.face.tolist(), cut.truncated
    (True, [1], [], True)
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
    _check_size(len(F0), header.levels, header.passes)
    ints = decode_positions(data[middle:end], F0)
    faces = faces_of(F0, header.levels, header.passes)
    packets = read_packets(data, start, faces, header.channels, header.total_features, crc & 0xFFFF,
                           batches=data[len(MAGIC)] > 2)
    if strict and packets.corrupt:
        raise StreamError(packets.corrupt)
    return ParsedStream(header, ints * 2.0**-header.position_bits, F0, packets.group, packets.face, packets.value,
                        (packets.features, packets.bytes), start, packets.truncated, packets.corrupt)


def _check_size(faces: int, levels: int, passes: int) -> None:
    total = faces * (4**levels - 1) // 3 * (1 + passes)
    if total > MAX_LEVEL_FACES:
        raise StreamError(f"Expected at most {MAX_LEVEL_FACES} faces in all groups of features, found {total}; "
                          "use fewer base faces or levels")


def _read_header(data: bytes) -> tuple[Header, int, int, int]:
    """Header, offset of the connectivity, bytes of connectivity, bytes of positions."""
    if not data:
        raise StreamError("Expected an .npmesh stream, found no data; the file is empty")
    if not data.startswith(MAGIC[:len(data)]):
        raise StreamError(f"Expected an .npmesh stream, found {data[:4]!r} at its start; this is another kind of file")
    if len(data) > len(MAGIC) and data[len(MAGIC)] > VERSION:
        raise StreamError(f"Expected format version {VERSION} or older, found {data[len(MAGIC)]}; update the extension")
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

    version, length = take(2)
    check_header(version >= 1, "a format version", version)
    name, weights_hash, (shape, bits) = take(length), take(8), take(2)
    levels = (shape & 7) + 1
    passes = take(1)[0] if version > 1 else 0
    check_header(passes <= MAX_PASSES, f"at most {MAX_PASSES} passes over the offsets", passes)
    steps = np.frombuffer(take(4 * levels * (1 + passes)), dtype="<f4")
    counts = number(), number(), number()
    *centre, size = _PLACE.unpack(take(_PLACE.size))
    sizes = number(), number()
    head = at
    if int.from_bytes(take(2), "big") != crc32(data[:head]) & 0xFFFF:
        raise StreamError("Expected an intact header, found a wrong checksum; the file is corrupted, get it again")
    check_header(sum(sizes) <= _MAX_BASE_BYTES, f"a base mesh of at most {_MAX_BASE_BYTES} bytes", sum(sizes))
    return Header(
        name.decode("ascii", "replace"), weights_hash, levels, bits, tuple(map(float, steps)), *counts,
        tuple(centre), size, (shape >> 3) + 1), at, *sizes
