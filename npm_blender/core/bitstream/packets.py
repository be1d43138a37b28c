"""Packets of features, in order of importance, on the wire.

A feature is one face's vector of integers at one of the levels 0..L - 1. `packet_sizes` fixes how many features each packet
holds, and how many packets make a batch. Batches are in order of importance; inside a batch features are sorted by (level,
face), since telling the order of features that are worth about the same costs more than it gains. All learned state carries
on, so a packet needs all packets before it.

On the wire: length of the payload (varint), payload, 16-bit CRC (CCITT) over both that starts from the CRC before
it. 16 bits find every single error burst of up to 16 bits and all but 1/65536 of other damage, the chain finds lost or
exchanged packets; whatever slips through still decodes to legal indices, so more bytes per packet would buy little.
"""
from binascii import crc_hqx
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..errors import StreamError
from ..jit import njit
from .feature_values import CONTEXTS, COUNT, LEVELS, LIMIT, MIXERS, STRIDE, code_latent
from .range_coder import code_signed, new_contexts, new_weights, range_decoder
from .significance import Faces, Sent, code_faces, nothing_sent
from .varint import read_varint

MAX_VALUE = (1 << 20) - 1
CRC_BYTES = 2  # behind each packet
BATCH = 6  # packets, from 400 features on; part of the format
LEVEL, PENDING, REST, WHOLE = 0, 1, 2, 3  # of a batch: level being coded, its features to come, those after it, all


def packet_sizes(total: int) -> list[list[int]]:
    """Features in each packet of each batch of a stream of `total`: 20 up to 40, 40 up to 400, then x1.15 each; the last
    is cut.

    The first batches are of one packet, that up to 400 features is one, then come batches of BATCH packets.
    """
    out: list[list[int]] = []
    size, done = 20, 0
    while done < total:
        if done == 40:
            size = 40
        elif done >= 400:
            size = size * 23 // 20
        goes_on = 40 < done < 400 or done > 400 and len(out[-1]) < BATCH
        if not goes_on:
            out.append([])
        out[-1].append(min(size, total - done))
        done += size
    return out


class Features(NamedTuple):
    """Features in the order of the stream, int64: level (k,), face (k,) of it, value (k, channels)."""

    level: np.ndarray
    face: np.ndarray
    value: np.ndarray


class PacketState(NamedTuple):
    """What both sides have learned. sent: see `Sent`; typical (L, channels): 256 times the recent mean magnitude;
    batch (4,): where the batch stands, see LEVEL; contexts, weights: of the coder."""

    sent: Sent
    typical: np.ndarray
    batch: np.ndarray
    contexts: np.ndarray
    weights: np.ndarray


@njit
def code_packet(coder, faces, state, features, at, size, whole):
    """Code features at..at + size in place. Returns False if the counts cannot be.

    whole: features of the batch, if this is its first packet, else 0.
    """
    batch, sent = state.batch, state.sent
    if whole:
        batch[LEVEL], batch[PENDING], batch[REST], batch[WHOLE] = -1, 0, whole, whole
    for row in range(at, at + size):
        while batch[PENDING] == 0:
            if not _next_level(coder, faces, state, features, row):
                return False
        lv = batch[LEVEL]
        code_latent(coder, faces, sent, state.typical, features.value, lv, faces.first[lv] + features.face[row], row)
        batch[PENDING] -= 1
    if batch[PENDING] + batch[REST] == 0:
        while batch[LEVEL] + 1 < len(sent.count):
            if not _next_level(coder, faces, state, features, at + size):
                return False
        sent.last[len(sent.count)] = batch[WHOLE]
    return True


@njit
def _next_level(coder, faces, state, features, at):
    """Code how many features of the batch are of the next level, and on which faces they sit, from row `at` on.

    The last level has what remains. Returns False if the counts cannot be.
    """
    batch, sent = state.batch, state.sent
    levels, rest = len(sent.count), batch[REST]
    batch[LEVEL] += 1
    lv = batch[LEVEL]
    if lv >= levels:
        return False
    count = rest
    if lv + 1 < levels:
        count = 0
        for r in range(at, at + rest):
            count += features.level[r] == lv
        likely = sent.last[lv] * batch[WHOLE] // sent.last[levels]
        c = (COUNT + min(lv, LEVELS - 1)) * STRIDE
        count = likely + code_signed(coder, count - likely, c, c, c, STRIDE, LIMIT)
    if count < 0 or count > rest or count > faces.first[lv + 1] - faces.first[lv] - sent.count[lv]:
        return False
    code_faces(coder, faces, sent, features.face, lv, at, count)
    for r in range(at, at + count):
        features.level[r] = lv
    batch[PENDING] = count
    batch[REST] -= count
    sent.last[lv] = count
    sent.count[lv] += count
    return True


def first_state(faces: Faces, channels: int) -> PacketState:
    """The state before the first packet."""
    sent = nothing_sent(faces)
    typical = np.full((len(sent.count), channels), 256, np.int64)
    return PacketState(sent, typical, np.zeros(4, np.int64), new_contexts(CONTEXTS), new_weights(MIXERS))


def most_bytes(size: int, channels: int, faces: int) -> int:
    """No payload of `size` features is longer."""
    return 1024 + size * (64 * channels + 64) + faces // 2


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


def read_packets(data: bytes, at: int, faces: Faces, channels: int, total: int, crc: int) -> Packets:
    """The features of all whole, undamaged packets in data[at:]; never raises for what follows them.

    faces, crc: as for `encode_packets`; channels: numbers per feature; total: number of features promised. Allocates
    for what the data can hold, and the batch that they end in, not for `total`.
    """
    state = first_state(faces, channels)
    sizes = packet_sizes(total)
    found, at, truncated, corrupt = _whole_packets(data, at, sum(sizes, []), channels, len(state.sent.row), crc)
    wholes = [sum(batch) if i == 0 else 0 for batch in sizes for i in range(len(batch))][:len(found)]
    k = sum(wholes)
    features = Features(np.zeros(k, np.int64), np.zeros(k, np.int64), np.zeros((k, channels), np.int64))
    arrived, ends = [0], [at]
    for (size, begin, end), whole in zip(found, wholes, strict=True):
        coder = range_decoder(state.contexts, state.weights, data[begin:end - CRC_BYTES])
        if not code_packet(coder, faces, state, features, arrived[-1], size, whole):
            corrupt, truncated = f"Expected a packet of features at byte {ends[-1]}, found impossible counts", False
            break
        arrived.append(arrived[-1] + size)
        ends.append(end)
    k = arrived[-1]
    return Packets(features.level[:k].astype(np.uint8), features.face[:k].astype(np.int32),
                   features.value[:k].astype(np.int32), np.array(arrived, np.int64), np.array(ends, np.int64),
                   truncated, corrupt)


def _whole_packets(data: bytes, at: int, sizes: list[int], channels: int, faces: int,
                   crc: int) -> tuple[list[tuple[int, int, int]], int, bool, str | None]:
    """(features, first payload byte, end) of each undamaged packet; offset of the first; truncated; what is wrong."""
    out: list[tuple[int, int, int]] = []
    start = at
    for size in sizes:
        try:
            length, begin = read_varint(data, at)
        except EOFError:
            return out, start, True, None
        except StreamError as e:
            return out, start, False, str(e)
        if length > most_bytes(size, channels, faces):
            return out, start, False, f"Expected a packet of features at byte {at}, found one of {length} bytes"
        end = begin + length + CRC_BYTES
        if end > len(data):
            return out, start, True, None
        crc = crc_hqx(data[at:end - CRC_BYTES], crc)
        if crc != int.from_bytes(data[end - CRC_BYTES:end], "big"):
            return out, start, False, f"Expected a packet of features at byte {at}, found a wrong checksum"
        out.append((size, begin, end))
        at = end
    if at != len(data):
        return out, start, False, f"Expected the end of the file at byte {at}, found {len(data) - at} bytes more"
    return out, start, False, None
