"""The container: streams of both kinds come back, any prefix opens, any damage is noticed."""
import subprocess
import sys
from binascii import crc_hqx
from dataclasses import replace
from pathlib import Path
from zlib import crc32

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.bitstream import (
    DisplacedCoding,
    Header,
    around,
    container,
    encode_displacements,
    read_stream,
    write_displaced,
    write_latents,
)
from npm_blender.core.bitstream.chunks import CRC_BYTES, chunk_ends
from npm_blender.core.bitstream.heads import MAGIC, VERSION
from npm_blender.core.errors import StreamError
from npm_blender.core.mesh import hierarchy
from tests.core.bitstream.frozen import make
from tests.core.bitstream.samples import LOW, creased_sample, displaced_sample, latent_sample, some_base
from tests.core.bitstream.test_displacements import first_numbers

SAMPLES = {"displaced": displaced_sample(), "creased": creased_sample(seed=1, levels=1, stages=2), "latents": latent_sample()}
READ = {name: read_stream(sample.data) for name, sample in SAMPLES.items()}
ALL = pytest.mark.parametrize("name", SAMPLES)


def same_beginning(read, name):
    """What was read is the beginning of the whole stream."""
    sample, whole = SAMPLES[name], READ[name]
    assert read.header == sample.header
    assert np.array_equal(read.grid, sample.grid) and np.array_equal(read.F0, sample.base.F0)
    if name == "latents":
        k = len(read.details.level)
        assert read.features == k
        for field in ("level", "face", "value"):
            assert np.array_equal(getattr(read.details, field), getattr(whole.details, field)[:k])
        return
    new = np.diff([0, *(level.n for level in hierarchy(read.F0, len(read.grid), read.header.levels))])
    expected = first_numbers(sample.features, whole.details.coded, np.concatenate([[0], np.cumsum(new)]), read.features)
    assert np.array_equal(read.details.table, expected)


@ALL
def test_a_stream_comes_back(name):
    read, sample = READ[name], SAMPLES[name]
    same_beginning(read, name)
    assert read.features == read.header.total_features and not read.truncated and read.corrupt is None
    assert read.grid.dtype == np.int64 and read.F0.dtype == np.int32
    assert read.ends[0][0] == 0 and read.ends[1][0] == read.base_bytes and read.ends[1][-1] == len(sample.data)
    assert (np.diff(read.ends[0]) > 0).all() and (np.diff(read.ends[1]) >= 0).all()


def test_latents_come_back():
    sent, came = SAMPLES["latents"].features, READ["latents"].details
    assert (came.level.dtype, came.face.dtype, came.value.dtype) == (np.uint8, np.int32, np.int32)
    assert {(a, b, *c) for a, b, c in zip(sent.level, sent.face, sent.value)} == \
        {(a, b, *c) for a, b, c in zip(came.level, came.face, came.value)}
    assert READ["latents"].ends[0].tolist() == [0, 20, 40, 80, 100]


def test_integers_come_back():
    for name in ("displaced", "creased"):
        assert np.array_equal(READ[name].details.table, SAMPLES[name].features)


def test_a_base_alone_is_a_stream():
    grid, base = some_base()
    header = Header(0, 12, 0, 7, 8, LOW, 2.5, DisplacedCoding(0, 0, 22, 0, 0))
    read = read_stream(write_displaced(header, base, b""))
    assert read.features == 0 and not read.truncated and not read.corrupt and np.array_equal(read.grid, grid)
    assert read.details.table.shape == (0, len(grid)) and read.ends[1].tolist() == [read.base_bytes]


def test_stages_without_a_number_are_a_stream_whose_base_is_all():
    sample = displaced_sample(table=np.zeros((2, SAMPLES["displaced"].features.shape[1]), np.int64))
    read = read_stream(sample.data)
    assert read.features == 0 and not read.truncated and not read.corrupt
    assert read.ends[1].tolist() == [read.base_bytes]


def test_creases_and_corners_come_back():
    sent, came = SAMPLES["creased"].sharp, READ["creased"].sharp
    assert np.array_equal(came.edges, sent.edges) and np.array_equal(came.corners, sent.corners) and sent.corners.any()
    assert READ["displaced"].sharp is None and READ["latents"].sharp is None


@ALL
def test_every_prefix_past_the_base_opens_and_holds_what_the_whole_says(name):
    whole, data = READ[name], SAMPLES[name].data
    numbers, ends = whole.ends
    for cut in range(whole.base_bytes, len(data)):
        read = read_stream(data[:cut])
        assert read.truncated and read.corrupt is None
        k = int(np.searchsorted(ends, cut, "right")) - 1
        assert numbers[k] <= read.features
        # the last numbers may need no byte of their own
        assert k + 1 == len(ends) or read.features < numbers[k + 1] or numbers[k + 1] == numbers[-1]
        same_beginning(read, name)


@ALL
def test_every_prefix_inside_the_base_is_refused_and_says_what_is_missing(name):
    for cut in range(READ[name].base_bytes):
        with pytest.raises(StreamError, match="Expected") as e:
            read_stream(SAMPLES[name].data[:cut])
        assert "\n" not in str(e.value)
    assert f"at least {READ[name].base_bytes} bytes" in str(e.value)


@ALL
def test_every_flipped_byte_is_noticed(name):
    data = SAMPLES[name].data
    for at in range(len(data)):
        try:
            read = read_stream(data[:at] + bytes([data[at] ^ (1 << at % 8)]) + data[at + 1:])
        except StreamError as error:
            assert at < READ[name].base_bytes and "\n" not in str(error)
        else:
            assert at >= READ[name].base_bytes and (read.corrupt or read.truncated)
            assert not read.corrupt or "Expected" in read.corrupt
            same_beginning(read, name)


@ALL
@settings(max_examples=100)
@given(st.data())
def test_any_damage_and_cut_ends_in_an_error_or_numbers(name, data):
    whole = SAMPLES[name].data
    damaged = bytearray(whole[:data.draw(st.integers(0, len(whole)))])
    for _ in range(data.draw(st.integers(0, 3)) if damaged else 0):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] ^= data.draw(st.integers(1, 255))
    try:
        read = read_stream(bytes(damaged))
    except StreamError as error:
        assert "Expected" in str(error)
    else:
        assert read.features <= READ[name].ends[0][-1] + 32


def head_of(sample, base_bytes):
    """Where the head of a stream ends."""
    return base_bytes - 4 - len(sample.base.connectivity) - len(sample.base.positions) - len(sample.base.sharp)


def mended(data, at, value, name):
    """The stream with another byte, and checksums that say that it is right, so that it reaches what comes behind them."""
    sample = SAMPLES[name]
    body, start = bytearray(data), READ[name].base_bytes
    body[at] = value
    head = head_of(sample, start)
    body[head - 2:head] = (crc32(body[:head - 2]) & 0xFFFF).to_bytes(2, "big")
    body[start - 4:start] = crc32(body[:start - 4]).to_bytes(4, "big")
    if name != "latents":
        crc, place, ends = int.from_bytes(body[start - 2:start], "big"), start, chunk_ends(sample.header.coding.payload)
        for size in np.diff([0, *ends]).tolist():
            crc = crc_hqx(body[place:place + size], crc)
            body[place + size:place + size + CRC_BYTES] = crc.to_bytes(2, "big")
            place += size + CRC_BYTES
    return bytes(body)


@pytest.mark.slow
@ALL
@settings(max_examples=300)
@given(st.data())
def test_damage_with_mended_checksums_is_refused_or_decodes(name, data):
    whole = SAMPLES[name].data
    at = data.draw(st.integers(4, len(whole) - 1))
    try:
        read = read_stream(mended(whole, at, data.draw(st.integers(0, 255)), name))
    except StreamError as error:
        assert "Expected" in str(error) and "\n" not in str(error)
    else:
        assert read.F0.min() >= 0 and read.F0.max() < len(read.grid) and read.features >= 0


@ALL
def test_nothing_but_a_mended_byte_is_refused_less(name):
    assert mended(SAMPLES[name].data, 4, VERSION, name) == SAMPLES[name].data


@ALL
def test_checksums_are_compared_whole(name):
    data, read = SAMPLES[name].data, READ[name]
    head = head_of(SAMPLES[name], read.base_bytes)
    places = [(head - k, "intact header") for k in (1, 2)] + [(read.base_bytes - k, "base mesh") for k in (1, 2, 3, 4)]
    for at, words in places:
        with pytest.raises(StreamError, match=words):
            read_stream(data[:at] + bytes([data[at] ^ 1]) + data[at + 1:])


def test_strict_reading_raises_what_reading_reports():
    data = bytearray(SAMPLES["displaced"].data)
    data[-1] ^= 1
    assert "wrong checksum" in read_stream(data).corrupt
    with pytest.raises(StreamError, match="wrong checksum"):
        read_stream(data, strict=True)
    assert "1 bytes more" in read_stream(SAMPLES["displaced"].data + b"\0").corrupt


@pytest.mark.parametrize("data, words", [
    (b"", "no data"), (b"ply\nformat", "another kind of file"), (MAGIC[:2] + b"xx", "another kind"),
    (MAGIC + bytes([VERSION + 1]), "update the extension"), (MAGIC + b"\3" + bytes(99), "before the first release"),
    (MAGIC + bytes([VERSION]), "the end of the file after 5 bytes"),
])
def test_what_is_no_stream_is_refused_in_words(data, words):
    with pytest.raises(StreamError, match=words):
        read_stream(data)


def test_a_promise_that_the_numbers_do_not_keep_is_reported():
    sample = SAMPLES["displaced"]
    payload, _ = encode_displacements(sample.features, around(hierarchy(sample.base.F0, len(sample.grid), 2)),
                                      np.array([0, *(x.n for x in hierarchy(sample.base.F0, len(sample.grid), 2))]))
    lying = replace(sample.header, total_features=sample.header.total_features + 1)
    assert f"Expected {lying.total_features} numbers" in read_stream(write_displaced(lying, sample.base, payload)).corrupt


@pytest.mark.parametrize("across, words", [(5, "numbers"), (15, "faces in all levels")])
def test_more_than_a_stream_may_hold_is_refused_before_it_is_made(across, words, monkeypatch):
    monkeypatch.setattr(container, "hierarchy", None)
    grid, base = some_base(across)
    header = Header(8, 12, 0, 1, 1, LOW, 1, DisplacedCoding(0, 0, 22, 24, 8, (0,) * 8))
    with pytest.raises(StreamError, match=f"Expected at most [0-9]+ {words}"):
        read_stream(write_displaced(header, base, bytes(8)))


@pytest.mark.parametrize("wrong", [{"level": [0, 3], "face": [0, 0]}, {"level": [0, 0], "face": [1, 1]},
                                   {"level": [0], "face": [0]}])
def test_latents_that_cannot_be_are_not_written(wrong):
    sample = latent_sample(2, across=2)
    features = replace(sample.features, **{k: np.array(v) for k, v in wrong.items()})
    if len(wrong["level"]) == 1:
        features = replace(features, value=features.value[:1])
    with pytest.raises(StreamError, match="Expected"):
        write_latents(sample.header, sample.base, features)


@pytest.mark.parametrize("low", [(1.0, -2.0, 0.5), (1e6 + 0.1, 0.0, 0.0)])
def test_a_corner_keeps_its_digits_and_takes_four_bytes_where_they_do(low):
    grid, base = some_base()
    header = Header(0, 12, 0, 7, 8, low, 2.5, DisplacedCoding(0, 0, 22, 0, 0))
    data = write_displaced(header, base, b"")
    assert read_stream(data).header.low == low
    narrow = write_displaced(replace(header, low=(0, 0, 0)), base, b"")
    assert len(data) - len(narrow) == (0 if np.float32(low[0]) == low[0] else 12)


def test_the_header_is_small():
    grid, base = some_base()
    header = Header(3, 12, 30_000, 100_000, 50_000, (0.5, 0, 0), 2.5, DisplacedCoding(8, 128, 22, 8, 20_000, (8, 8, 8)))
    data = write_displaced(header, base, b"")
    assert len(data) - len(base.connectivity) - len(base.positions) <= 56


@pytest.mark.parametrize("kind", ["displaced", "latents", "ladder"])
def test_streams_of_version_4_open_for_ever(kind):
    data = (Path(make.__file__).parent / f"{kind}_4.npmesh").read_bytes()
    read, sample = read_stream(data, strict=True), getattr(make, kind)()
    rungs = sample.rungs if kind == "ladder" else [sample]
    assert len(read.rungs) == len(rungs) and sample.data == data
    for one, sent in zip(read.rungs, rungs, strict=True):
        assert replace(one.header, followed=False, total_features=one.features) == sent.header
        assert np.array_equal(one.grid, sent.grid) and np.array_equal(one.F0, sent.base.F0)
        assert (one.sharp is None) == (sent.sharp is None)
        assert sent.sharp is None or all(map(np.array_equal, one.sharp, sent.sharp))
        if kind != "latents":
            assert np.array_equal(one.details.table, sent.features)
    if kind != "latents":
        assert np.array_equal(read.details.table, make.numbers())


def test_plain_python_reads_and_writes_the_same_bytes(tmp_path):
    for name, sample in (("a", displaced_sample(levels=1, stages=2)), ("b", latent_sample(20, across=2)), ("c", make.ladder())):
        (tmp_path / name).write_bytes(sample.data)
    script = ("import sys; sys.modules['numba'] = None\n"
              "from npm_blender.core.jit import COMPILED\n"
              "from npm_blender.core.bitstream import read_stream\n"
              "from tests.core.bitstream.samples import displaced_sample, latent_sample\n"
              "from tests.core.bitstream.frozen import make\n"
              "assert not COMPILED\n"
              f"a, b, c = (open({str(tmp_path)!r} + name, 'rb').read() for name in ('/a', '/b', '/c'))\n"
              "assert (read_stream(a).details.table == displaced_sample(levels=1, stages=2).features).all()\n"
              "assert displaced_sample(levels=1, stages=2).data == a and latent_sample(20, across=2).data == b\n"
              "assert make.ladder().data == c and len(read_stream(c, strict=True).rungs) == 2\n"
              "assert read_stream(b, strict=True).features == 20\n")
    done = subprocess.run([sys.executable, "-W", "error::RuntimeWarning", "-c", script], capture_output=True, text=True,
                          cwd=Path(__file__).parents[3])
    assert done.returncode == 0, done.stderr
