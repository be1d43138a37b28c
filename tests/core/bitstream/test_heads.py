"""Heads of rungs: they come back, every damage is noticed, and what cannot be is refused."""
from dataclasses import replace
from zlib import crc32

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npm_blender.core.bitstream.header import DisplacedCoding, Header, LatentCoding
from npm_blender.core.bitstream.heads import MAGIC, VERSION, BaseSizes, read_head, write_head
from npm_blender.core.errors import StreamError

CODING = DisplacedCoding(smooth=8, step=300, growth=22, stages=3, payload=1000, ends=(3, 2))
PLAIN = Header(2, 12, 5000, 100_000, 50_002, (1.0, -2.0, 0.5), 2.5, CODING)
HEADS = {"numbers": PLAIN, "followed": replace(PLAIN, followed=True), "a corner in float64": replace(PLAIN, low=(0.1, 1e6, 0)),
         "a base alone": Header(0, 9, 0, 8, 6, (0, 0, 0), 1.0, DisplacedCoding(0, 0, 22, 0, 0)),
         "latents": replace(PLAIN, coding=LatentCoding("default", bytes(range(8)), (0.5, 1.0), 8))}
SIZES = BaseSizes(300, 70_000, 17)
LATER = {"numbers": replace(PLAIN, levels=1, position_bits=14, coding=replace(CODING, ends=(1,))),
         "followed": HEADS["followed"], "a base alone": replace(HEADS["a base alone"], source_faces=1)}
BEFORE = 0xDEADBEEF  # CRC of the base before a later head
FIRST = HEADS["a corner in float64"]  # of the stream of all later heads


def written(name):
    """A head and what comes behind it."""
    header = HEADS[name]
    sizes = SIZES._replace(sharp=0) if name == "latents" else SIZES
    return write_head(header, sizes), header, sizes


def mended(head, before=0):
    """The head with a checksum that says that it is right."""
    return head[:-2] + (crc32(head[:-2], before) & 0xFFFF).to_bytes(2, "big")


@pytest.mark.parametrize("name", HEADS)
def test_a_first_head_comes_back(name):
    data, header, sizes = written(name)
    assert read_head(data + b"more") == (header, sizes, len(data))
    assert data.startswith(MAGIC + bytes([VERSION])) and (len(data) <= 64 or name == "latents")


@pytest.mark.parametrize("at", [0, 3, 500])
@pytest.mark.parametrize("name", LATER)
def test_a_later_head_comes_back_with_the_source_of_the_first(name, at):
    data = write_head(LATER[name], SIZES, BEFORE)
    expected = replace(LATER[name], source_faces=FIRST.source_faces, source_vertices=FIRST.source_vertices, low=FIRST.low,
                       size=FIRST.size)
    assert read_head(bytes(at) + data + b"more", at, FIRST, BEFORE) == (expected, SIZES, at + len(data))


@pytest.mark.parametrize("name", LATER)
def test_a_later_head_leaves_out_what_the_first_has_said(name):
    first, later = (write_head(LATER[name], SIZES, before) for before in (None, BEFORE))
    assert len(first) - len(later) >= 5 + 2 + 16 and MAGIC not in later


@given(st.integers(0, 8), st.integers(4, 20), st.integers(0, 1 << 25), st.integers(0, 1 << 40), st.floats(-1e9, 1e9),
       st.integers(0, 8), st.integers(0, 1023), st.integers(0, 24), st.booleans(), st.booleans(), st.data())
def test_any_head_comes_back(levels, bits, total, source, x, smooth, step, stages, followed, first, data):
    numbers = st.integers(0, (1 << 26) // 3)
    sizes = BaseSizes(*(data.draw(numbers) for _ in range(3)))
    ends = tuple(data.draw(st.integers(0, 24)) for _ in range(levels))
    coding = DisplacedCoding(smooth, step, data.draw(st.integers(1, 64)), stages, data.draw(st.integers(0, (1 << 30) - 1)), ends)
    header = Header(levels, bits, total, source, source // 2, (x, 0, -x), 2.5, coding, followed)
    head = write_head(header, sizes, None if first else BEFORE)
    assert read_head(head, 0, None if first else header, 0 if first else BEFORE) == (header, sizes, len(head))


@pytest.mark.parametrize("name", HEADS)
def test_every_flipped_byte_of_a_first_head_is_noticed(name):
    data = written(name)[0]
    for at in range(len(data)):
        for bit in range(8):
            with pytest.raises(StreamError, match="Expected") as e:
                read_head(data[:at] + bytes([data[at] ^ (1 << bit)]) + data[at + 1:] + bytes(99))
            assert "\n" not in str(e.value)


@pytest.mark.parametrize("name", LATER)
def test_every_flipped_byte_of_a_later_head_is_noticed(name):
    data = write_head(LATER[name], SIZES, BEFORE)
    for at in range(len(data)):
        for bit in range(8):
            with pytest.raises(StreamError, match="Expected"):
                read_head(data[:at] + bytes([data[at] ^ (1 << bit)]) + data[at + 1:] + bytes(300), 0, FIRST, BEFORE)


@pytest.mark.parametrize("name", HEADS)
def test_a_first_head_that_is_cut_says_what_is_missing(name):
    data = written(name)[0]
    for cut in range(1, len(data)):
        with pytest.raises(StreamError, match=f"after {cut} bytes; get the rest of the file"):
            read_head(data[:cut])


@pytest.mark.parametrize("name", LATER)
def test_a_later_head_that_is_cut_is_an_end_of_the_data(name):
    data = write_head(LATER[name], SIZES, BEFORE)
    for cut in range(len(data)):
        with pytest.raises(EOFError):
            read_head(data[:cut], 0, FIRST, BEFORE)


FLAGS = len(MAGIC) + 1
REFUSED = {
    "an unknown flag": (PLAIN, SIZES, True, {FLAGS: 8}, "known flags"),
    "latents with another rung": (HEADS["latents"], SIZES._replace(sharp=0), True, {FLAGS: 5}, "one rung without creases"),
    "latents with creases": (HEADS["latents"], SIZES, True, {}, "one rung without creases"),
    "later latents": (HEADS["latents"], SIZES._replace(sharp=0), False, {}, "known flags"),
    "a corner of a later rung": (PLAIN, SIZES, False, {0: 2}, "known flags"),
    "too large a base": (PLAIN, BaseSizes(1 << 26, 0, 1), True, {}, "at most 67108864 bytes"),
    "too large a later base": (PLAIN, BaseSizes(0, 1, 1 << 26), False, {}, "at most 67108864 bytes"),
    "few bits": (PLAIN, SIZES, True, {FLAGS + 1: 3}, "4 to 20 bits"),
    "few bits of a later base": (PLAIN, SIZES, False, {1: 3}, "4 to 20 bits"),
    "too smooth a scheme": (PLAIN, SIZES, False, {2: 2 << 4 | 9}, "a smoothness of 0 to 8"),
}


@pytest.mark.parametrize(("header", "sizes", "first", "changes", "words"), REFUSED.values(), ids=REFUSED)
def test_what_no_head_can_say_is_refused(header, sizes, first, changes, words):
    data = bytearray(write_head(header, sizes, None if first else BEFORE))
    for at, value in changes.items():
        data[at] = value
    with pytest.raises(StreamError, match=words):
        read_head(mended(bytes(data), 0 if first else BEFORE), 0, None if first else FIRST, 0 if first else BEFORE)


@given(st.binary(max_size=80), st.booleans())
def test_any_bytes_are_refused_or_a_head(data, first):
    try:
        found = read_head(MAGIC + bytes([VERSION]) + data if first else data, 0, None if first else FIRST, 0 if first else BEFORE)
    except (StreamError, EOFError) as error:
        assert "Expected" in str(error) or not first
    else:
        assert isinstance(found.header, Header)


@pytest.mark.parametrize("at", range(3, 40))
def test_any_value_with_a_mended_checksum_is_refused_or_a_head(at):
    for name in HEADS:
        data = written(name)[0]
        for value in range(0, 256, 5):
            try:
                found = read_head(mended(data[:at] + bytes([value]) + data[at + 1:]) + bytes(99))
            except StreamError as error:
                assert "Expected" in str(error)
            else:
                assert np.isfinite(found.header.low).all()
