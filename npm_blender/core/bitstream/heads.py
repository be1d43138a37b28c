"""The heads of rungs as bytes: that of the first says what the stream is of, all say what their rung is."""
import struct
from typing import NamedTuple
from zlib import crc32

import numpy as np

from ..errors import StreamError
from .header import DisplacedCoding, Header, LatentCoding, check_header
from .varint import read_varint, write_varint

MAGIC = b"\x8aNPM"
VERSION = 4                     # 1 to 3 came before the first release
_MAX_BASE_BYTES = 1 << 26       # connectivity and positions of the largest base mesh stay far below
_LATENTS, _WIDE, _FOLLOWED, _FLAGS = 1, 2, 4, 7  # flags: the features are latents; the corner is float64; another rung follows


class BaseSizes(NamedTuple):
    """Bytes of a base: of its connectivity, of its positions, of its creases and corners."""

    connectivity: int
    positions: int
    sharp: int


class Head(NamedTuple):
    """A head that was read: header; sizes: of the base; end: the offset behind it."""

    header: Header
    sizes: BaseSizes
    end: int


def write_head(header: Header, sizes: BaseSizes, before: int | None = None) -> bytes:
    """The head of a rung, with its checksum; before: CRC of the base of the rung before, None where it begins the stream."""
    first = before is None
    coding, place = header.coding, np.array(header.low)
    wide = bool((place.astype(np.float32) != place).any())
    if isinstance(coding, LatentCoding):
        latent, smooth, name = True, 0, coding.model_id.encode("ascii")
        said = [bytes([len(name)]), name, coding.weights_hash, bytes([coding.channels]), np.array(coding.steps, "<f4").tobytes()]
    else:
        latent, smooth = False, coding.smooth
        said = [write_varint(coding.step), bytes([coding.growth, coding.stages]), write_varint(coding.payload),
                bytes(coding.ends)]
    flags = latent * _LATENTS + (first and wide) * _WIDE + header.followed * _FOLLOWED
    head = b"".join([
        MAGIC + bytes([VERSION]) if first else b"",
        bytes([flags, header.position_bits, header.levels << 4 | smooth]), write_varint(header.total_features),
        _source(header, wide) if first else b"", *said, *map(write_varint, sizes)])
    return head + (crc32(head, before or 0) & 0xFFFF).to_bytes(2, "big")


def _source(header: Header, wide: bool) -> bytes:
    return b"".join([write_varint(header.source_faces), write_varint(header.source_vertices),
                     np.array(header.low, "<f8" if wide else "<f4").tobytes(), struct.pack("<f", header.size)])


def read_head(data: bytes, at: int = 0, first: Header | None = None, before: int = 0) -> Head:
    """The head of a rung at an offset; first: the header that begins the stream, None for that itself; before: CRC of the base
    of the rung before.

    Raises StreamError (no data, foreign, of another version, damaged), EOFError where the data end inside a later head.
    """
    if first is None:
        _check_magic(data)
    try:
        return _read_fields(data, at, first, before)
    except EOFError:
        if first is not None:
            raise
        raise StreamError(f"Expected a whole header, found the end of the file after {len(data)} bytes; "
                          "get the rest of the file") from None


def _check_magic(data: bytes) -> None:
    if not data:
        raise StreamError("Expected an .npmesh stream, found no data; the file is empty")
    if not data.startswith(MAGIC[:len(data)]):
        raise StreamError(f"Expected an .npmesh stream, found {data[:4]!r} at its start; this is another kind of file")
    if len(data) > len(MAGIC) and data[len(MAGIC)] != VERSION:
        found = data[len(MAGIC)]
        what = "update the extension" if found > VERSION else "it was made before the first release, compress the original again"
        raise StreamError(f"Expected format version {VERSION}, found {found}; {what}")


class _Bytes:
    """Data that are read from an offset on. Raises EOFError at their end."""

    def __init__(self, data: bytes, at: int) -> None:
        self.data, self.at = data, at

    def take(self, count: int) -> bytes:
        """The next bytes."""
        if self.at + count > len(self.data):
            raise EOFError
        self.at += count
        return self.data[self.at - count:self.at]

    def number(self) -> int:
        """The next varint."""
        value, self.at = read_varint(self.data, self.at)
        return value


def _read_fields(data: bytes, at: int, first: Header | None, before: int) -> Head:
    """As `read_head`. Raises EOFError if the data end inside the head."""
    read = _Bytes(data, at if first else at + len(MAGIC) + 1)
    flags, bits, shape = read.take(3)
    features, levels = read.number(), shape >> 4
    if first is None:
        counts = read.number(), read.number()
        low = np.frombuffer(read.take(24 if flags & _WIDE else 12), "<f8" if flags & _WIDE else "<f4").astype(np.float64)
        (size,) = struct.unpack("<f", read.take(4))
    else:
        counts, low, size = (first.source_faces, first.source_vertices), np.array(first.low), first.size
    latent: tuple = ()
    displaced: tuple = ()
    if flags & _LATENTS:
        (length,) = read.take(1)
        latent = (read.take(length).decode("ascii", "replace"), read.take(8), read.take(1)[0],
                  np.frombuffer(read.take(4 * levels), "<f4"))
    else:
        displaced = shape & 15, read.number(), *read.take(2), read.number(), tuple(read.take(levels))
    sizes = BaseSizes(read.number(), read.number(), read.number())
    end = read.at
    if int.from_bytes(read.take(2), "big") != crc32(data[at:end], before) & 0xFFFF:
        raise StreamError("Expected an intact header, found a wrong checksum; the file is corrupted, get it again")
    check_header(flags <= _FLAGS and not (first and flags & (_WIDE | _LATENTS)), "known flags", flags)
    check_header(not latent or not (sizes.sharp or flags & _FOLLOWED), "one rung without creases beside latents", flags)
    check_header(sum(sizes) <= _MAX_BASE_BYTES, f"a base mesh of at most {_MAX_BASE_BYTES} bytes", sum(sizes))
    if latent:
        name, digest, channels, steps = latent
        coding: DisplacedCoding | LatentCoding = LatentCoding(name, digest, tuple(map(float, steps)), channels)
    else:
        coding = DisplacedCoding(*displaced)
    x, y, z = map(float, low)
    return Head(Header(levels, bits, features, *counts, (x, y, z), size, coding, bool(flags & _FOLLOWED)), sizes, read.at)
