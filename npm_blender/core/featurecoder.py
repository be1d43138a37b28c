"""Packets of features: which faces they sit on, and their quantized values, in order of importance.

A feature is one face's vector of integers at one level 0..L-1. `packet_sizes` fixes how many features each packet
holds. Inside a packet features are sorted by (level, face). Per level the packet tells for each face not yet sent
whether it is sent now; the chance of that is shared out by weights that follow what the faces around it did (parent
sent, neighbours sent), learned from packet to packet. Values are coded channel by channel with contexts from the same
vector, the parent and the neighbours. All learned state carries on, so a packet needs all packets before it.

On the wire: length of the payload (varint), payload, 16-bit CRC (CCITT) over both that starts from the CRC before
it. 16 bits find every single error burst of up to 16 bits and all but 1/65536 of other damage, the chain finds lost or
exchanged packets; whatever slips through still decodes to legal indices, so more bytes per packet would buy little.
"""
from binascii import crc_hqx
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .errors import StreamError
from .jit import njit
from .rangecoder import (
    ENCODE,
    MODE,
    ONE,
    code_probability,
    code_signed,
    decoder,
    encoder,
    finish,
    new_contexts,
    new_weights,
)
from .topology import opposite_halfedges
from .varint import read_varint, write_varint

MAX_VALUE = (1 << 20) - 1
_LIMIT = 14                     # magnitudes by context up to here, above Exp-Golomb
_STRIDE = _LIMIT + 1
_LEVELS, _CHANNELS = 6, 32      # levels and channels that have contexts of their own
_OWN = _LEVELS * _CHANNELS
_AROUND = _OWN + 12 * _CHANNELS
_COUNT = _AROUND + 12 * 20
_CONTEXTS = (_COUNT + _LEVELS) * _STRIDE
_MIXERS = 2 * _STRIDE
_CLASSES = 8                    # parent unsent / sent x neighbours sent 0..3, of level 0 and of the finer levels
_ONE_WEIGHT = 1 << 8
_MAX_WEIGHT = 1 << 14
_PRIOR = 4 << 8                 # the learned weights start as if this many (8 fractional bits) had behaved as expected


class _Faces(NamedTuple):
    """Faces of all feature levels, numbered one level after the other.

    first (L + 1,) int64: first face of each level; neighbours (total, 3) int32: itself across a border.
    """

    first: np.ndarray
    neighbours: np.ndarray


class _State(NamedTuple):
    """What both sides have learned and know. row (total,) int32: 1 + index of the feature of a face, 0 unsent;
    weights (2 * _CLASSES,), typical (L, channels): 256 x recent mean magnitude, sent (L,), last (L + 1,): counts of the
    packet before, and its size."""

    row: np.ndarray
    weights: np.ndarray
    typical: np.ndarray
    sent: np.ndarray
    last: np.ndarray


def packet_sizes(total: int) -> list[int]:
    """Features in each packet of a stream of `total`: 20 up to 40, 40 up to 400, then x1.15 each; the last is cut."""
    out, size, done = [], 20, 0
    while done < total:
        if done == 40:
            size = 40
        elif done >= 400:
            size = size * 23 // 20
        out.append(min(size, total - done))
        done += size
    return out


def _refined(opposite: np.ndarray) -> np.ndarray:
    """Opposite half-edges (12 m,) of the subdivided faces, given those (3 m,) of the faces; see `subdivide`."""
    m = len(opposite) // 3
    h = np.arange(3 * m)
    f, k = h // 3, h % 3
    after = h // 3 * 3 + (k + 1) % 3
    half_one, half_two = 3 * (h // 3 * 4 + k), 3 * (after // 3 * 4 + after % 3) + 2
    border = opposite == h
    out = np.empty(12 * m, dtype=np.int64)
    out[half_one] = np.where(border, half_one, half_two[opposite])
    out[half_two] = np.where(border, half_two, half_one[opposite])
    inner, centre = 3 * (4 * f + (k + 1) % 3) + 1, 3 * (4 * f + 3) + k
    out[inner], out[centre] = centre, inner
    return out


def _faces(F0: np.ndarray, levels: int) -> _Faces:
    opposite = opposite_halfedges(F0).astype(np.int64)
    first, tables = [0], []
    for i in range(levels):
        tables.append((first[-1] + opposite // 3).reshape(-1, 3).astype(np.int32))
        first.append(first[-1] + len(opposite) // 3)
        if i + 1 < levels:
            opposite = _refined(opposite)
    return _Faces(np.array(first, dtype=np.int64), np.concatenate(tables))


@njit
def _bits(value):
    out = 0
    while value > 0:
        out += 1
        value >>= 1
    return out


@njit
def _class_of(faces, state, level, g):
    """Class of an unsent face g of a level by what was sent around it."""
    around = 0
    for t in range(3):
        around += state.row[faces.neighbours[g, t]] > 0
    if level == 0:
        return around
    parent = faces.first[level - 1] + (g - faces.first[level]) // 4
    return _CLASSES + 4 * (state.row[parent] > 0) + around


@njit
def _code_faces(coder, faces, state, face, level, at, count):
    """Which `count` of the unsent faces of a level are sent now, face[at:at + count] ascending."""
    sending = coder.rc[MODE] == ENCODE
    first, stop = faces.first[level], faces.first[level + 1]
    rest, total = 0, 0
    for g in range(first, stop):
        if state.row[g] == 0:
            total += state.weights[_class_of(faces, state, level, g)]
            rest += 1
    hits, expected = np.zeros(2 * _CLASSES, np.int64), np.zeros(2 * _CLASSES, np.int64)
    for g in range(first, stop):
        if count == 0:
            break
        if state.row[g] > 0:
            continue
        kind = _class_of(faces, state, level, g)
        weight = state.weights[kind]
        p = min(max((count * weight << 22) // max(total, 1), 1), ONE - (ONE >> 6))
        now = 1
        if count < rest:
            now = 1 if sending and face[at] == g - first else 0
            now = code_probability(coder, now, p)
            expected[kind] += p >> 14
            hits[kind] += now << 8
        total -= weight
        rest -= 1
        if now:
            for t in range(3):
                o = faces.neighbours[g, t]
                if o > g and state.row[o] == 0:
                    total -= state.weights[_class_of(faces, state, level, o)]
            face[at] = g - first
            at += 1
            count -= 1
            state.row[g] = at
            for t in range(3):
                o = faces.neighbours[g, t]
                if o > g and state.row[o] == 0:
                    total += state.weights[_class_of(faces, state, level, o)]
    for c in range(2 * _CLASSES):
        weight = state.weights[c] * (hits[c] + _PRIOR) // (expected[c] + _PRIOR)
        state.weights[c] = min(max(weight, 4), _MAX_WEIGHT)


@njit
def _code_value(coder, faces, state, value, level, g, row):
    """The integers of the feature of face g, value[row]."""
    own, lv = 0, min(level, _LEVELS - 1)
    parent = -1
    if level > 0:
        parent = state.row[faces.first[level - 1] + (g - faces.first[level]) // 4] - 1
    for c in range(value.shape[1]):
        around, known = 0, 0
        for t in range(3):
            o = state.row[faces.neighbours[g, t]] - 1
            if o >= 0 and o < row:
                around += abs(value[o, c])
                known += 1
        if parent >= 0:
            around += abs(value[parent, c])
            known += 1
        # around: 0 nothing known, else 1 + size of the doubled mean
        near = min(1 + _bits(2 * around // known), 11) if known > 0 else 0
        i = (lv * _CHANNELS + c) * _STRIDE
        j = (_OWN + min(_bits(own), 11) * _CHANNELS + c) * _STRIDE
        k = (_AROUND + near * 20 + min(_bits(state.typical[level, c]), 19)) * _STRIDE
        v = code_signed(coder, value[row, c], i, j, k, 0, _LIMIT)
        value[row, c] = v
        own += abs(v)
        state.typical[level, c] += ((abs(v) << 8) - state.typical[level, c]) >> 4


@njit
def _code_packet(coder, faces, state, level, face, value, at, size):
    """Code features at..at + size in place. Returns False if the counts cannot be."""
    levels = len(state.sent)
    rest, start = size, at
    for lv in range(levels):
        unsent = faces.first[lv + 1] - faces.first[lv] - state.sent[lv]
        count = 0
        for r in range(at, start + size):
            count += level[r] == lv
        if lv + 1 < levels:
            likely = state.last[lv] * size // state.last[levels]
            c = (_COUNT + min(lv, _LEVELS - 1)) * _STRIDE
            count = likely + code_signed(coder, count - likely, c, c, c, _STRIDE, _LIMIT)
        else:
            count = rest
        if count < 0 or count > rest or count > unsent:
            return False
        _code_faces(coder, faces, state, face, lv, at, count)
        for r in range(at, at + count):
            level[r] = lv
            _code_value(coder, faces, state, value, lv, faces.first[lv] + face[r], r)
        state.last[lv] = count
        state.sent[lv] += count
        at += count
        rest -= count
    state.last[levels] = size
    return True


def _start(F0: np.ndarray, levels: int, channels: int) -> tuple[_Faces, _State, np.ndarray, np.ndarray]:
    faces = _faces(F0, levels)
    last = np.ones(levels + 1, np.int64)
    last[levels] = levels
    state = _State(np.zeros(faces.first[-1], np.int32), np.full(2 * _CLASSES, _ONE_WEIGHT, np.int64),
                   np.full((levels, channels), 256, np.int64), np.zeros(levels, np.int64), last)
    return faces, state, new_contexts(_CONTEXTS), new_weights(_MIXERS)


def _most_bytes(size: int, channels: int, faces: int) -> int:
    """No payload of `size` features is longer."""
    return 1024 + size * (64 * channels + 64) + faces // 2


def encode_packets(F0: np.ndarray, levels: int, level: np.ndarray, face: np.ndarray, value: np.ndarray,
                   crc: int) -> list[bytes]:
    """Packets of k features in their order of importance.

    F0 (m0, 3): base faces as the receiver sees them; level (k,) in 0..levels - 1; face (k,) in 0..m0 4^level - 1;
    value (k, channels) integers; crc: 16 bits that the first packet's CRC starts from.
    Raises StreamError if a face comes twice, or an index or value is out of range.
    """
    level, face, value = (np.array(a, dtype=np.int64) for a in (level, face, value))
    faces, state, contexts, weights = _start(F0, levels, value.shape[1])
    fits = (0 <= level) & (level < levels) & (0 <= face) & (np.abs(value) <= MAX_VALUE).all(1)
    if not fits.all():
        raise StreamError(f"Expected features of levels 0..{levels - 1} and values within +-{MAX_VALUE}, found others")
    number = faces.first[level] + face
    if (number >= faces.first[level + 1]).any() or len(np.unique(number)) != len(number):
        raise StreamError("Expected at most one feature per existing face, found one twice or beyond the last face")
    out, at = [], 0
    for size in packet_sizes(len(level)):
        part = slice(at, at + size)
        order = at + np.argsort(number[part], kind="stable")
        level[part], face[part], value[part] = level[order], face[order], value[order]
        coder = encoder(contexts, weights, _most_bytes(size, value.shape[1], len(state.row)))
        _code_packet(coder, faces, state, level, face, value, at, size)
        payload = finish(coder)
        packet = write_varint(len(payload)) + payload
        crc = crc_hqx(packet, crc)
        out.append(packet + crc.to_bytes(2, "big"))
        at += size
    return out


@dataclass(frozen=True)
class Packets:
    """Features that arrived: level (k,) uint8, face (k,) int32, value (k, channels) int32, in the order of the stream.

    features, bytes (p + 1,) int64: features and byte offset at the start and at the end of each whole packet;
    truncated: the data end before the last packet does; corrupt: what is wrong with the next packet, or None.
    """

    level: np.ndarray
    face: np.ndarray
    value: np.ndarray
    features: np.ndarray
    bytes: np.ndarray
    truncated: bool
    corrupt: str | None


def read_packets(data: bytes, at: int, F0: np.ndarray, levels: int, channels: int, total: int, crc: int) -> Packets:
    """The features of all whole, undamaged packets in data[at:]; never raises for what follows them.

    F0, levels, channels, crc: as for `encode_packets`; total: number of features promised. Allocates for what the
    data can hold, not for `total`.
    """
    faces, state, contexts, weights = _start(F0, levels, channels)
    found, at, truncated, corrupt = _whole_packets(data, at, packet_sizes(total), channels, len(state.row), crc)
    k = sum(size for size, _, _ in found)
    level, face, value = np.zeros(k, np.int64), np.zeros(k, np.int64), np.zeros((k, channels), np.int64)
    features, ends = [0], [at]
    for size, begin, end in found:
        coder = decoder(contexts, weights, data[begin:end - 2])
        if not _code_packet(coder, faces, state, level, face, value, features[-1], size):
            corrupt, truncated = f"Expected a packet of features at byte {ends[-1]}, found impossible counts", False
            break
        features.append(features[-1] + size)
        ends.append(end)
    k = features[-1]
    return Packets(level[:k].astype(np.uint8), face[:k].astype(np.int32), value[:k].astype(np.int32),
                   np.array(features, np.int64), np.array(ends, np.int64), truncated, corrupt)


def _whole_packets(data: bytes, at: int, sizes: list[int], channels: int, faces: int,
                   crc: int) -> tuple[list[tuple[int, int, int]], int, bool, str | None]:
    """(features, first payload byte, end) of each undamaged packet; offset of the first; truncated; what is wrong."""
    out, start = [], at
    for size in sizes:
        try:
            length, begin = read_varint(data, at)
        except EOFError:
            return out, start, True, None
        except StreamError as e:
            return out, start, False, str(e)
        if length > _most_bytes(size, channels, faces):
            return out, start, False, f"Expected a packet of features at byte {at}, found one of {length} bytes"
        end = begin + length + 2
        if end > len(data):
            return out, start, True, None
        crc = crc_hqx(data[at:end - 2], crc)
        if crc != int.from_bytes(data[end - 2:end], "big"):
            return out, start, False, f"Expected a packet of features at byte {at}, found a wrong checksum"
        out.append((size, begin, end))
        at = end
    if at != len(data):
        return out, start, False, f"Expected the end of the file at byte {at}, found {len(data) - at} bytes more"
    return out, start, False, None


def decode_packets(data: bytes, at: int, F0: np.ndarray, levels: int, channels: int, total: int, crc: int) -> Packets:
    """As `read_packets`, but raises StreamError with the byte offset if a packet is damaged; a cut end is no damage."""
    packets = read_packets(data, at, F0, levels, channels, total, crc)
    if packets.corrupt:
        raise StreamError(packets.corrupt)
    return packets
