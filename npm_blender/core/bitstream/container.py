"""The `.npmesh` container: header, base mesh, features. docs/format.md is its specification.

Every prefix that holds the base mesh is a valid stream of fewer features.
"""
from collections.abc import Sequence
from dataclasses import replace
from itertools import accumulate
from typing import NamedTuple
from zlib import crc32

import numpy as np

from ..errors import StreamError
from ..mesh import Level, Sharp, hierarchy, opposite_halfedges
from .base_positions import decode_positions, encode_positions
from .chunks import CRC_BYTES, arrived, chunk_ends, with_checksums
from .connectivity import decode_connectivity, encode_connectivity
from .displacements import around, decode_displacements
from .header import (
    BASE_NUMBERS,
    MAX_LEVEL_FACES,
    MAX_NUMBERS,
    MAX_RUNGS,
    DisplacedCoding,
    DisplacedNumbers,
    Header,
    LatentCoding,
    LatentFeatures,
    ParsedStream,
    check_header,
)
from .heads import BaseSizes, read_head, write_head
from .packet_encoder import encode_packets
from .packets import Features, read_packets
from .sharp_coding import decode_sharp, encode_sharp
from .significance import faces_of

_CRC_BYTES = 4                  # behind a base mesh


class EncodedBase(NamedTuple):
    """A coded base mesh: faces F0 (m0, 3) in `canonical_order`; bytes of its connectivity, positions, creases and corners.

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
    sharp: bytes = b""


def encode_base(grid: np.ndarray, F0: np.ndarray, connectivity: bytes | None = None, sharp: Sharp | None = None) -> EncodedBase:
    """Code a base mesh: grid (n0, 3), lattice positions; F0 (m0, 3) in `canonical_order`; sharp: its creases and corners.

    connectivity: the bytes of F0, where they are at hand (`order_connectivity`). Raises MeshError if something is out of
    range, or if F0 is in another order.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import encode_base
    >>> base = encode_base(np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]), np.array([[0, 1, 2], [3, 1, 0]]))
    >>> len(base.connectivity)
    5
    """
    return EncodedBase(F0, encode_connectivity(F0) if connectivity is None else connectivity, encode_positions(grid, F0),
                       encode_sharp(sharp, grid, Level.of(F0, len(grid))) if sharp else b"")


def _body(header: Header, base: EncodedBase, before: int | None = None) -> bytes:
    """Head and base mesh of a rung, with their checksums; before: that of the base before, None for the first."""
    sizes = BaseSizes(len(base.connectivity), len(base.positions), len(base.sharp))
    body = write_head(header, sizes, before) + base.connectivity + base.positions + base.sharp
    return body + crc32(body, before or 0).to_bytes(_CRC_BYTES, "big")


class Rung(NamedTuple):
    """A rung to be written: header; base; payload: from `encode_displacements`, as long as `header.coding` says.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import *  # all of the room
    >>> base = encode_base(np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]), np.array([[0, 1, 2], [3, 1, 0]]))
    >>> Rung(Header(0, 8, 0, 2, 4, (0, 0, 0), 1.0, DisplacedCoding(0, 0, 22, 0, 0)), base, b"").payload
    b''
    """

    header: Header
    base: EncodedBase
    payload: bytes


def write_displaced(header: Header, base: EncodedBase, payload: bytes) -> bytes:
    """A whole stream of one displaced surface; payload: from `encode_displacements`, as long as `header.coding` says.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import *  # all of the room
    >>> F0 = np.array([[0, 1, 2], [3, 1, 0]])
    >>> base = encode_base(np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]), F0)
    >>> header = Header(0, 8, 0, 2, 4, (0, 0, 0), 1.0, DisplacedCoding(0, 0, 22, 0, 0))
    >>> read_stream(write_displaced(header, base, b"")).grid.tolist()
    [[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 0]]
    """
    return write_ladder([Rung(header, base, payload)])


def write_ladder(rungs: Sequence[Rung]) -> bytes:
    """A stream of rungs, each finer than the one before; their headers say how many features they have themselves.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import *  # all of the room
    >>> header = Header(0, 8, 0, 2, 4, (0, 0, 0), 1.0, DisplacedCoding(0, 0, 22, 0, 0))
    >>> F0 = np.array([[0, 1, 2], [3, 1, 0]])
    >>> bases = [encode_base(size * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]), F0) for size in (9, 10)]
    >>> read = read_stream(write_ladder([Rung(header, base, b"") for base in bases]))
    >>> read.header.total_features, read.finer.grid[3].tolist()  # the coordinates of the second base count
    (12, [10, 10, 0])
    """
    features = [rung.header.total_features + (BASE_NUMBERS * (int(rung.base.F0.max()) + 1) if place else 0)
                for place, rung in enumerate(rungs)]
    out, crc = b"", None
    for place, (header, base, payload) in enumerate(rungs):
        header = replace(header, total_features=sum(features[place:]), followed=place + 1 < len(rungs))
        body = _body(header, base, crc)
        crc = int.from_bytes(body[-_CRC_BYTES:], "big")
        out += body + with_checksums(payload, crc & 0xFFFF)
    return out


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
    parsed = _read_rung(data, 0, None)
    wrong = next((rung.corrupt for rung in parsed.rungs if rung.corrupt), None)
    if strict and wrong:
        raise StreamError(wrong)
    return parsed


class _Below(NamedTuple):
    """What is below a later rung: first, the header that begins the stream; crc of the last base; how many rungs."""

    first: Header
    crc: int
    rungs: int


def _read_rung(data: bytes, at: int, below: _Below | None) -> ParsedStream:
    """The rung at an offset and those behind it; below: None for the first.

    Raises StreamError as `read_stream`, EOFError where the data end before the base of a later rung does.
    """
    header, sizes, middle = read_head(data, at, below.first, below.crc) if below else read_head(data, at)
    _, positions, sharp, end = accumulate(sizes, initial=middle)
    start = end + _CRC_BYTES
    if len(data) < start:
        if below:
            raise EOFError
        raise StreamError(f"Expected at least {start} bytes (the base mesh), found {len(data)}; "
                          "get the rest of the file")
    crc = crc32(data[at:end], below.crc if below else 0)
    if crc != int.from_bytes(data[end:start], "big"):
        raise StreamError("Expected an intact base mesh, found a wrong checksum; the file is corrupted, get it again")
    F0 = decode_connectivity(data[middle:positions])
    _check_size(len(F0), header)
    grid = decode_positions(data[positions:sharp], F0)
    if isinstance(header.coding, LatentCoding):
        return _read_latents(data, start, header, grid, F0, crc & 0xFFFF)
    folds = decode_sharp(data[sharp:end], grid, Level.of(F0, len(grid)))
    parsed, behind = _read_displaced(data, start, header, grid, F0, crc & 0xFFFF)
    here = _Below(below.first if below else header, crc, below.rungs + 1 if below else 1)
    return _with_finer(data, behind, replace(parsed, sharp=folds), here)


def _with_finer(data: bytes, at: int, parsed: ParsedStream, below: _Below) -> ParsedStream:
    """A rung with what follows it, whose offset is `at`, 0 where it has not arrived; below: what is below that."""
    header, finer, wrong = parsed.header, None, parsed.corrupt
    truncated = parsed.truncated
    if at and header.followed:
        try:
            check_header(below.rungs < MAX_RUNGS, f"at most {MAX_RUNGS} rungs", MAX_RUNGS + 1)
            finer = _read_rung(data, at, below)
        except EOFError:
            truncated = True
        except StreamError as error:
            wrong = str(error)
    elif at and at < len(data):
        wrong = f"Expected the end of the file at byte {at}, found {len(data) - at} bytes more"
    if at and not wrong and (finer or not header.followed):
        own = header.total_features - (finer.header.total_features if finer else 0)
        own -= 0 if below.rungs == 1 else BASE_NUMBERS * len(parsed.grid)
        if own != parsed.features:
            wrong = f"Expected {own} numbers, found {parsed.features}"
    if at and parsed.features:  # what is behind the last number belongs to it
        parsed.ends[1][-1] = at
    return replace(parsed, finer=finer, corrupt=wrong, truncated=truncated)


def _read_latents(data: bytes, start: int, header: Header, grid: np.ndarray, F0: np.ndarray, crc: int) -> ParsedStream:
    assert isinstance(header.coding, LatentCoding)
    faces = faces_of(F0, header.levels)
    packets = read_packets(data, start, faces, header.coding.channels, header.total_features, crc)
    return ParsedStream(header, grid, F0, LatentFeatures(packets.level, packets.face, packets.value),
                        (packets.features, packets.bytes), start, packets.truncated, packets.corrupt)


def _read_displaced(data: bytes, start: int, header: Header, grid: np.ndarray, F0: np.ndarray,
                    crc: int) -> tuple[ParsedStream, int]:
    """A rung alone, and the offset behind it, 0 if it has not arrived whole."""
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
    arrived_numbers = np.minimum(np.arange(len(at)) * coded.group, coded.numbers)
    parsed = ParsedStream(header, grid, F0, DisplacedNumbers(coded.table, coded.coded), (arrived_numbers, at), start,
                          found.truncated, found.corrupt)
    return parsed, found.end


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
