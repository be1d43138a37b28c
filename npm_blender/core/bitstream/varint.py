"""Whole numbers in one to nine bytes: seven bits each, lowest first, the high bit set on all but the last."""
from ..errors import StreamError

_LONGEST = 9


def write_varint(value: int) -> bytes:
    """The bytes of 0 <= value < 2**63; known as LEB128.

    >>> from npm_blender.core.bitstream import write_varint
    >>> [write_varint(value).hex() for value in (0, 127, 128, 300)]
    ['00', '7f', '8001', 'ac02']
    """
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    out.append(value)
    return bytes(out)


def read_varint(data: bytes, at: int) -> tuple[int, int]:
    """(value, offset after it) of the number at offset `at`.

    Raises EOFError if the data end inside it, StreamError if it is longer than nine bytes.

    >>> from npm_blender.core.bitstream import read_varint
    >>> read_varint(bytes.fromhex("ffac02ff"), 1)
    (300, 3)
    """
    value = 0
    for i in range(_LONGEST):
        if at + i >= len(data):
            raise EOFError
        value |= (data[at + i] & 127) << 7 * i
        if data[at + i] < 128:
            return value, at + i + 1
    raise StreamError(f"Expected a number of at most {_LONGEST} bytes at byte {at}, found a longer one; "
                      "the file is corrupted")
