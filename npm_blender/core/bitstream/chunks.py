"""A payload that is cut into chunks, each with a checksum: damage is found, and what came before it is kept.

Chunks grow with what came before them: the next has an eighth of it, at least LEAST bytes. Behind each stands a 16-bit
CRC (CCITT) that starts from the CRC before it. The payload bytes of a chunk that is not whole yet are used as they come.
"""
from binascii import crc_hqx
from typing import NamedTuple

LEAST, SHARE, CRC_BYTES = 256, 8, 2


def chunk_ends(size: int) -> list[int]:
    """Payload bytes at the end of each chunk of a payload of `size` bytes."""
    out, done = [], 0
    while done < size:
        done = min(size, done + max(LEAST, done // SHARE))
        out.append(done)
    return out


def with_checksums(payload: bytes, crc: int) -> bytes:
    """The payload with the CRC of each chunk behind it; crc: 16 bits that the first starts from."""
    out, start = [], 0
    for end in chunk_ends(len(payload)):
        crc = crc_hqx(payload[start:end], crc)
        out += [payload[start:end], crc.to_bytes(CRC_BYTES, "big")]
        start = end
    return b"".join(out)


class Arrived(NamedTuple):
    """What of a payload has arrived: its bytes; whether that is not all; what is wrong with the next chunk, or None; where it
    ends, if it is whole."""

    payload: bytes
    truncated: bool
    corrupt: str | None
    end: int = 0


def arrived(data: bytes, at: int, size: int, crc: int) -> Arrived:
    """The payload of `size` bytes whose chunks begin at data[at:], as far as it is there and whole."""
    out, start = [], 0
    for end in chunk_ends(size):
        piece = data[at:at + end - start]
        out.append(piece)
        at += end - start
        check = data[at:at + CRC_BYTES]
        if len(piece) < end - start or len(check) < CRC_BYTES:
            return Arrived(b"".join(out), True, None)
        crc = crc_hqx(piece, crc)
        if crc != int.from_bytes(check, "big"):
            where = at - (end - start)
            return Arrived(b"".join(out[:-1]), False, f"Expected intact numbers from byte {where} on, found a wrong checksum")
        at, start = at + CRC_BYTES, end
    return Arrived(b"".join(out), False, None, at)
