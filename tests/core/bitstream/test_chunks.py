"""Chunks: whatever arrives is known to be what was sent, or is the part of a chunk that has not ended."""
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from npm_blender.core.bitstream.chunks import CRC_BYTES, LEAST, arrived, chunk_ends, with_checksums

PAYLOAD = np.random.default_rng(0).integers(0, 256, 2000, np.uint8).tobytes()
FRAMED = with_checksums(PAYLOAD, 77)


@given(st.integers(0, 1 << 30))
def test_chunks_cover_the_payload_and_grow(size):
    ends = chunk_ends(size)
    lengths = np.diff([0, *ends])
    assert (ends[-1] if ends else 0) == size and (lengths > 0).all() and len(ends) < 200
    assert (lengths[:-1] >= LEAST).all() and (np.diff(lengths[:-1]) >= 0).all()


@given(st.integers(0, 2000), st.binary(max_size=9))
def test_a_payload_comes_back(size, before):
    framed = before + with_checksums(PAYLOAD[:size], 77)
    found = arrived(framed, len(before), size, 77)
    assert found.payload == PAYLOAD[:size] and not found.truncated and found.corrupt is None
    assert found.end == len(framed) == len(before) + size + CRC_BYTES * len(chunk_ends(size))


def test_what_follows_a_payload_is_not_looked_at():
    found = arrived(FRAMED + b"more", 0, len(PAYLOAD), 77)
    assert found == arrived(FRAMED, 0, len(PAYLOAD), 77) and found.end == len(FRAMED)


def test_every_prefix_gives_what_is_there():
    before = 0
    for cut in range(len(FRAMED)):
        found = arrived(FRAMED[:cut], 0, len(PAYLOAD), 77)
        assert found.truncated and found.corrupt is None and PAYLOAD.startswith(found.payload) and not found.end
        checks = sum(end + CRC_BYTES * (k + 1) <= cut for k, end in enumerate(chunk_ends(len(PAYLOAD))))
        assert before <= len(found.payload) <= cut - CRC_BYTES * checks <= len(found.payload) + CRC_BYTES
        before = len(found.payload)


def test_every_flipped_byte_is_noticed_and_what_came_before_is_kept():
    ends = chunk_ends(len(PAYLOAD))
    framed_ends = [end + CRC_BYTES * (k + 1) for k, end in enumerate(ends)]
    for at in range(len(FRAMED)):
        bad = FRAMED[:at] + bytes([FRAMED[at] ^ (1 << at % 8)]) + FRAMED[at + 1:]
        found = arrived(bad, 0, len(PAYLOAD), 77)
        whole = int(np.searchsorted(framed_ends, at, "right"))
        assert "wrong checksum" in found.corrupt and not found.end and found.payload == PAYLOAD[:[0, *ends][whole]]


def test_lost_exchanged_and_foreign_chunks_are_noticed():
    ends = [0, *(end + CRC_BYTES * (k + 1) for k, end in enumerate(chunk_ends(len(PAYLOAD))))]
    pieces = [FRAMED[a:b] for a, b in zip(ends, ends[1:])]
    for wrong in (pieces[1:], [pieces[1], pieces[0], *pieces[2:]], [*pieces[:2], pieces[1], *pieces[3:]]):
        assert arrived(b"".join(wrong), 0, len(PAYLOAD), 77).corrupt
    assert arrived(FRAMED, 0, len(PAYLOAD), 78).corrupt
