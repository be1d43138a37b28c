"""The `.npmesh` container: header, base mesh, packets of features. docs/format.md is its specification.

Every prefix that holds the base mesh is a valid stream of fewer features.
"""
import math
import struct
from dataclasses import dataclass
from zlib import crc32

import numpy as np

from .basecoder import MAX_BITS, MIN_BITS, decode_positions, encode_positions
from .connectivity import decode_connectivity, encode_connectivity
from .errors import StreamError
from .featurecoder import MAX_LEVEL_FACES, encode_packets, read_packets
from .mesh import Frame
from .varint import read_varint, write_varint

MAGIC = b"\x8aNPM"
VERSION = 1
MAX_LEVELS, MAX_CHANNELS, MAX_NAME = 8, 32, 32
MAX_SOURCE = 1 << 40            # faces and vertices of the source: only shown, never allocated
_MAX_BASE_BYTES = 1 << 26       # connectivity and positions of the largest base mesh stay far below
_PLACE = struct.Struct("<4d")


@dataclass(frozen=True)
class Header:
    """What a stream says about itself. Feature levels are 0..levels - 1.

    model_id: ASCII, 1 to 32 characters; weights_hash: 8 bytes; position_bits: lattice step 2**-bits in the unit frame;
    feature_steps: one float32 per feature level; total_features: of the whole stream, arrived or not; source_faces,
    source_vertices: of the mesh that was compressed; centre, size: unit frame to object space, see `Frame`;
    channels: numbers per feature. Raises StreamError if a field is out of range.
    """

    model_id: str
    weights_hash: bytes
    levels: int
    position_bits: int
    feature_steps: tuple[float, ...]
    total_features: int
    source_faces: int
    source_vertices: int
    centre: tuple[float, float, float]
    size: float
    channels: int = 8

    def __post_init__(self) -> None:
        steps = tuple(float(np.float32(s)) for s in self.feature_steps)
        object.__setattr__(self, "feature_steps", steps)
        object.__setattr__(self, "centre", tuple(float(c) for c in self.centre))
        object.__setattr__(self, "size", float(self.size))
        _check(self.model_id.isascii() and self.model_id.isprintable() and 1 <= len(self.model_id) <= MAX_NAME,
               f"model id of 1 to {MAX_NAME} ASCII characters", self.model_id)
        _check(len(self.weights_hash) == 8, "weights hash of 8 bytes", self.weights_hash)
        _check(1 <= self.levels <= MAX_LEVELS, f"1 to {MAX_LEVELS} levels", self.levels)
        _check(1 <= self.channels <= MAX_CHANNELS, f"1 to {MAX_CHANNELS} channels", self.channels)
        _check(MIN_BITS <= self.position_bits <= MAX_BITS, f"{MIN_BITS} to {MAX_BITS} bits", self.position_bits)
        _check(len(steps) == self.levels and all(0 < s < math.inf for s in steps), "one positive step per level", steps)
        _check(0 <= self.total_features <= MAX_LEVEL_FACES, f"at most {MAX_LEVEL_FACES} features", self.total_features)
        _check(0 <= self.source_faces <= MAX_SOURCE and 0 <= self.source_vertices <= MAX_SOURCE,
               f"at most {MAX_SOURCE} source faces and vertices", (self.source_faces, self.source_vertices))
        _check(len(self.centre) == 3 and all(map(math.isfinite, self.centre)) and 0 < self.size < math.inf,
               "a finite centre and a positive size", (self.centre, self.size))

    @property
    def frame(self) -> Frame:
        """Unit frame of everything in the stream."""
        return Frame(np.array(self.centre), self.size)


def _check(fine: bool, expected: str, found: object) -> None:
    if not fine:
        raise StreamError(f"Expected {expected} in the header, found {found!r}; the file is corrupted")


@dataclass(frozen=True)
class Stream:
    """A stream as far as it has arrived.

    V0 (n0, 3) float64: base positions, unit frame; F0 (m0, 3) int32; level (k,) uint8, face (k,) int32, value
    (k, channels) int32: the features that arrived; packet_ends: (features, bytes), int64 (p + 1,) each: cumulative
    features and offset in the file at the end of the base mesh and of each packet; base_bytes: offset of the first
    packet; truncated: the data end before the last promised feature; corrupt: what damage ended the reading, or None.
    """

    header: Header
    V0: np.ndarray
    F0: np.ndarray
    level: np.ndarray
    face: np.ndarray
    value: np.ndarray
    packet_ends: tuple[np.ndarray, np.ndarray]
    base_bytes: int
    truncated: bool
    corrupt: str | None


def write_stream(header: Header, V0_ints: np.ndarray, F0: np.ndarray, level: np.ndarray, face: np.ndarray,
                 value: np.ndarray) -> bytes:
    """A whole stream.

    V0_ints (n0, 3): lattice positions (`quantize_positions`); F0 (m0, 3) in `canonical_order`; level (k,), face (k,),
    value (k, channels): features in order of importance, k = header.total_features.
    Raises StreamError or MeshError if something is out of range, MeshError if F0 is in another order.
    """
    value = np.asarray(value)
    if value.shape != (header.total_features, header.channels) or len(level) != len(value) or len(face) != len(value):
        raise StreamError(f"Expected {header.total_features} features of {header.channels} numbers, found {value.shape}; "
                          "give level, face and value of equal lengths")
    _check_size(len(F0), header.levels)
    connectivity = encode_connectivity(F0)
    positions = encode_positions(V0_ints, F0)
    name = header.model_id.encode("ascii")
    head = b"".join([
        MAGIC, bytes([VERSION, len(name)]), name, header.weights_hash,
        bytes([header.levels - 1 | header.channels - 1 << 3, header.position_bits]),
        np.array(header.feature_steps, dtype="<f4").tobytes(),
        *map(write_varint, (header.total_features, header.source_faces, header.source_vertices)),
        _PLACE.pack(*header.centre, header.size), *map(write_varint, (len(connectivity), len(positions)))])
    body = head + (crc32(head) & 0xFFFF).to_bytes(2, "big") + connectivity + positions
    crc = crc32(body)
    packets = encode_packets(F0, header.levels, level, face, value, crc & 0xFFFF)
    return b"".join([body, crc.to_bytes(4, "big"), *packets])


def read_stream(data: bytes, strict: bool = False) -> Stream:
    """Read a stream, or any prefix of one past its base mesh.

    Raises StreamError if the data are no stream, from a newer version, damaged in header or base mesh, or end before
    the base mesh does. Damage in the packets ends the reading there: see Stream.corrupt, or StreamError if `strict`.
    """
    data = bytes(data)
    header, at, connectivity_bytes, position_bytes = _read_header(data)
    middle = at + connectivity_bytes
    end = middle + position_bytes
    if len(data) < end + 4:
        raise StreamError(f"Expected at least {end + 4} bytes (the base mesh), found {len(data)}; "
                          "get the rest of the file")
    crc = crc32(data[:end])
    if crc != int.from_bytes(data[end:end + 4], "big"):
        raise StreamError("Expected an intact base mesh, found a wrong checksum; the file is corrupted, get it again")
    F0 = decode_connectivity(data[at:middle])
    _check_size(len(F0), header.levels)
    ints = decode_positions(data[middle:end], F0)
    packets = read_packets(data, end + 4, F0, header.levels, header.channels, header.total_features, crc & 0xFFFF)
    if strict and packets.corrupt:
        raise StreamError(packets.corrupt)
    return Stream(header, ints * 2.0**-header.position_bits, F0, packets.level, packets.face, packets.value,
                  (packets.features, packets.bytes), end + 4, packets.truncated, packets.corrupt)


def _check_size(faces: int, levels: int) -> None:
    total = faces * (4**levels - 1) // 3
    if total > MAX_LEVEL_FACES:
        raise StreamError(f"Expected at most {MAX_LEVEL_FACES} faces in all feature levels, found {total}; "
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

    at = len(MAGIC)
    version, length = take(2)
    _check(version >= 1, "a format version", version)
    name, weights_hash, (shape, bits) = take(length), take(8), take(2)
    levels = (shape & 7) + 1
    steps = np.frombuffer(take(4 * levels), dtype="<f4")
    counts = number(), number(), number()
    *centre, size = _PLACE.unpack(take(_PLACE.size))
    sizes = number(), number()
    head = at
    if int.from_bytes(take(2), "big") != crc32(data[:head]) & 0xFFFF:
        raise StreamError("Expected an intact header, found a wrong checksum; the file is corrupted, get it again")
    _check(sum(sizes) <= _MAX_BASE_BYTES, f"a base mesh of at most {_MAX_BASE_BYTES} bytes", sum(sizes))
    return Header(
        name.decode("ascii", "replace"), weights_hash, levels, bits, tuple(map(float, steps)), *counts,
        tuple(centre), size, (shape >> 3) + 1), at, *sizes
