import subprocess
import sys
from dataclasses import replace
from hashlib import sha256

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.bitstream import packets
from npm_blender.core.bitstream.base_positions import quantize_positions
from npm_blender.core.bitstream.connectivity import canonical_order
from npm_blender.core.bitstream.container import MAGIC, VERSION, Header, read_stream, write_stream
from npm_blender.core.bitstream.header import MAX_LEVEL_FACES
from npm_blender.core.errors import StreamError
from npm_blender.core.mesh.subdivision import hierarchy
from tests.meshes.base_meshes import TETRAHEDRON, some_features, sphere

HEADER = Header("default", b"\1\2\3\4\5\6\7\x08", 3, 12, (0.1, 0.2, 0.4), 0, 100_000, 50_002, (1.0, -2.0, 0.1), 2.5)


def stream(features, across=3, seed=0):
    """Bytes of a stream, and what went in."""
    rng = np.random.default_rng(seed)
    V, F = sphere(across)
    order = canonical_order(F, len(V))
    ints, Vq = quantize_positions(V[order.vertices], 12)
    level, face, value = some_features(len(F), 3, features, rng)
    header = replace(HEADER, total_features=len(level))
    return write_stream(header, ints, order.F, level, face, value), (header, Vq, order.F, level, face, value)


FROZEN = (
    "8a4e504d010764656661756c7401020304050607083a0ccdcccc3dcdcc4c3ecdcccc3e2da08d06d28603000000000000f03f000000000000"
    "00c09a9999999999b93f0000000000000440051585a50400ffffc07c9f972b0e58b8023465ae2ef5cd4178794f799f78d4eef0265f040d15"
    "94c7be1be129db9d8a812cb6d23e634c77c93f1538bd3ba2329022df63e925b39a32ca50648f827cf6ed03cc89883e70daf4c2a14391227b"
    "8095fb44fee4914e5f0a14857e9d7598996c0b185a2c81cdfcff373233a8c7468af07220fc4354ec411c4a72f40afb7a90d3c40390a0fe12"
    "5fcac4593bca5dd7ce08ef81d7c2455d17567510090a31b4ff1785aedfb5486a061a6fda6228d5be87982f9c279ff54e4b5cd0518441d730"
    "0c3094f40d6d4f2a5ac680c2ef158ecb88f56deb0bb1d840cbfcdd821adede1ac7c03286c7"
)

FROZEN_2 = (
    "8a4e504d020764656661756c740102030405060708390c02cdcccc3dcdcc4c3e6f12833a6f12033b17b7d13817b7513925a08d06d2860300"
    "0000000000f03f00000000000000c09a9999999999b93f0000000000000440051539d10400ffffc07c9f972b0e58b8023465ae2ef5cd4178"
    "794f799f789e863c4a17890d149a237fd7b00b62f6088478fd638100e39a369580af6a0f09e14a972c4525c8b29b234900b8c04852"
)

FROZEN_3 = (
    "8a4e504d030764656661756c740102030405060708390c02cdcccc3dcdcc4c3e6f12833a6f12033b17b7d13817b7513925a08d06d2860300"
    "0000000000f03f00000000000000c09a9999999999b93f00000000000004400515e5500400ffffc07c9f972b0e58b8023465ae2ef5cd4178"
    "794f799f787fcda6e117890d149a237fd7b00b62f6088478fd638100e39a3695804f870f09e14a972c4525c8b29b234900b8c07b1b"
)

DATA, SENT = stream(100)
READ = read_stream(DATA)


def same_prefix(read):
    """What was read is the whole stream's beginning."""
    k = len(read.group)
    assert np.array_equal(read.V0, READ.V0) and np.array_equal(read.F0, READ.F0) and read.header == READ.header
    assert np.array_equal(read.group, READ.group[:k]) and np.array_equal(read.face, READ.face[:k])
    assert np.array_equal(read.value, READ.value[:k]) and read.packet_ends[0][-1] == k


def test_a_stream_comes_back():
    header, Vq, F0, level, face, value = SENT
    assert READ.header == header and np.array_equal(READ.V0, Vq) and np.array_equal(READ.F0, F0)
    assert READ.V0.dtype == np.float64 and READ.F0.dtype == np.int32 and READ.group.dtype == np.uint8
    assert READ.face.dtype == np.int32 and READ.value.dtype == np.int32
    sent = {(a, b): tuple(c) for a, b, c in zip(level, face, value, strict=True)}
    assert sent == {(a, b): tuple(c) for a, b, c in zip(READ.group, READ.face, READ.value, strict=True)}
    features, ends = READ.packet_ends
    assert features.tolist() == [0, 20, 40, 80, 100] and ends[0] == READ.base_bytes and ends[-1] == len(DATA)
    assert not READ.truncated and READ.corrupt is None
    assert np.array_equal(READ.header.frame.to_object(np.zeros((1, 3))), [[1.0, -2.0, 0.1]])


def test_no_features_is_a_stream_too():
    read = read_stream(stream(0)[0])
    assert len(read.group) == 0 and read.value.shape == (0, 8) and not read.truncated
    assert read.packet_ends[0].tolist() == [0]


def test_header_is_compact():
    data, (header, _, F0, *_) = stream(0)
    rest = data[data.index(np.array(HEADER.centre, "<f8").tobytes()) + 32:]
    assert len(data) - len(rest) + 6 <= 90


def test_every_prefix_past_the_base_opens():
    for cut in range(READ.base_bytes, len(DATA)):
        read = read_stream(DATA[:cut])
        assert read.truncated and read.corrupt is None
        assert len(read.group) == READ.packet_ends[0][np.searchsorted(READ.packet_ends[1], cut, "right") - 1]
        same_prefix(read)


def test_every_prefix_inside_the_base_is_refused_and_says_what_is_missing():
    for cut in range(READ.base_bytes):
        with pytest.raises(StreamError, match="Expected") as e:
            read_stream(DATA[:cut])
        assert "\n" not in str(e.value)
    assert f"at least {READ.base_bytes} bytes" in str(e.value)


@settings(deadline=None, max_examples=500)
@given(st.integers(0, 8 * len(DATA) - 1), st.integers(0, len(DATA)))
def test_any_bit_flip_and_cut_ends_in_an_error_or_a_shorter_read(bit, cut):
    data = bytearray(DATA)
    data[bit // 8] ^= 1 << bit % 8
    try:
        read = read_stream(bytes(data[:cut]))
    except StreamError as e:
        assert "\n" not in str(e)
        return
    same_prefix(read)
    if cut > bit // 8:
        assert read.corrupt or read.truncated
        if read.corrupt:
            with pytest.raises(StreamError):
                read_stream(bytes(data[:cut]), strict=True)


@settings(deadline=None, max_examples=300)
@given(st.binary(max_size=200), st.integers(0, len(DATA)), st.integers(0, 200))
def test_any_replaced_bytes_end_in_an_error_or_a_shorter_read(junk, at, skip):
    try:
        read = read_stream(DATA[:at] + junk + DATA[at + skip:])
    except StreamError:
        return
    same_prefix(read)


@settings(deadline=None, max_examples=300)
@given(st.binary(max_size=300))
def test_any_bytes_after_the_magic_are_refused(junk):
    with pytest.raises(StreamError):
        read_stream(MAGIC + bytes([VERSION]) + junk)


@pytest.mark.parametrize("data, words", [
    (b"", "empty"), (b"ply\nformat ascii 1.0", "another kind"), (b"\x89PNG", "another kind"),
    (MAGIC, "whole header"), (MAGIC + bytes([VERSION + 1]) + DATA[5:], "update the extension"),
    (MAGIC + b"\0" + DATA[5:], "version"),
    (DATA[:20] + b"\xff" + DATA[21:], "header.*checksum"),
    (DATA[:READ.base_bytes - 9] + b"\x55" + DATA[READ.base_bytes - 8:], "base mesh.*checksum"),
])
def test_bad_data_by_name(data, words):
    with pytest.raises(StreamError, match=words):
        read_stream(data)


@pytest.mark.parametrize("change", [
    {"levels": 0}, {"levels": 9}, {"position_bits": 3}, {"position_bits": 30}, {"feature_steps": (0.1, 0.2)},
    {"feature_steps": (0.1, 0.0, 1.0)}, {"feature_steps": (0.1, float("nan"), 1.0)}, {"model_id": ""},
    {"model_id": "x" * 33}, {"model_id": "größe"}, {"weights_hash": b"1"}, {"total_features": MAX_LEVEL_FACES + 1},
    {"total_features": -1}, {"source_faces": -1}, {"size": 0.0}, {"centre": (0.0, 0.0, float("inf"))}, {"channels": 33},
])
def test_impossible_headers_are_refused(change):
    with pytest.raises(StreamError, match="header"):
        replace(HEADER, **change)


def test_counts_must_agree_with_the_features():
    header, Vq, F0, level, face, value = SENT
    ints = quantize_positions(Vq, 12)[0]
    with pytest.raises(StreamError, match="features"):
        write_stream(replace(header, total_features=99), ints, F0, level, face, value)
    with pytest.raises(StreamError, match="features"):
        write_stream(header, ints, F0, level, face, value[:, :7])
    with pytest.raises(StreamError, match="fewer base faces or levels"):
        write_stream(replace(HEADER, levels=8, feature_steps=(1.0,) * 8), *_large_base(), [], [], np.zeros((0, 8), int))


def _large_base():
    V, F = sphere(40)
    order = canonical_order(F, len(V))
    return quantize_positions(V[order.vertices], 12)[0], order.F


def small_stream():
    """Arguments of `write_stream` made of plain arithmetic, the same on every machine."""
    k = np.arange(45)
    number = k * 11 % 84                                 # of 4 + 16 + 64 faces, each at most once
    level = np.searchsorted([4, 20], number, side="right")
    value = (k[:, None] * 7 + np.arange(8) * 5) % 13 - 6
    ints = np.array([[5, -9, 100], [-700, 20, 3], [650, 800, -77], [0, -1024, 512]])
    return (replace(HEADER, total_features=45), ints, canonical_order(TETRAHEDRON, 4).F, level,
            number - np.array([0, 4, 20])[level], value)


def test_version_1_is_frozen():
    """Files in the world must stay readable: these bytes never change as long as readers open version 1."""
    data = bytes.fromhex(FROZEN)
    header, ints, F0, level, face, value = small_stream()
    read = read_stream(data, strict=True)
    assert read.header == header and np.array_equal(read.V0 * 4096, ints) and np.array_equal(read.F0, F0)
    assert {(a, b): tuple(c) for a, b, c in zip(read.group, read.face, read.value, strict=True)} == \
           {(a, b): tuple(c) for a, b, c in zip(level, face, value, strict=True)}
    assert read.packet_ends[0].tolist() == [0, 20, 40, 45]


def offset_stream():
    """What goes into a stream of version 2: latents of three faces, then offsets of most faces in two passes."""
    F0 = canonical_order(TETRAHEDRON, 4).F
    features = [(0, f, [f - 1, 2, -3, 0, 1, 0, 5, -1]) for f in range(3)]
    for p in (1, 2):
        for i, level in enumerate(hierarchy(F0, 4, 1)):
            edges = np.arange(len(level.edges)) % 5 - 2
            features += [(2 * p + i, f, [*edges[level.edge_of[3 * f:3 * f + 3]], 0, 0, 0, 0, 0])
                         for f in range(len(level.F)) if f % 7 != 3]
    group, face, value = (np.array(a) for a in zip(*features, strict=True))
    ints = np.array([[5, -9, 100], [-700, 20, 3], [650, 800, -77], [0, -1024, 512]])
    steps = (0.1, 0.2, 1e-3, 2e-3, 1e-4, 2e-4)
    header = replace(HEADER, levels=2, feature_steps=steps, total_features=len(group))
    return header, ints, F0, group, face, value


def test_version_2_is_frozen():
    data = bytes.fromhex(FROZEN_2)
    header, ints, F0, group, face, value = offset_stream()
    read = read_stream(data, strict=True)
    assert read.header == header and read.header.passes == 2 and data[4] == 2
    assert np.array_equal(read.V0 * 4096, ints) and np.array_equal(read.F0, F0)
    assert {(a, b): tuple(c) for a, b, c in zip(read.group, read.face, read.value, strict=True)} == \
           {(a, b): tuple(c) for a, b, c in zip(group, face, value, strict=True)}


def test_version_3_is_frozen():
    """Its features beyond 40, of which no stream is short, are frozen by their digest."""
    data = bytes.fromhex(FROZEN_3)
    read = read_stream(data, strict=True)
    assert read.header == offset_stream()[0] and np.array_equal(read.V0 * 4096, offset_stream()[1])
    before = read_stream(bytes.fromhex(FROZEN_2))
    assert all(np.array_equal(getattr(read, name), getattr(before, name)) for name in ("group", "face", "value"))
    assert write_stream(*offset_stream()) == data
    header, ints, F0, *_ = small_stream()
    F0 = canonical_order(sphere(6)[1], int(sphere(6)[1].max()) + 1).F
    ints = np.arange(3 * (F0.max() + 1)).reshape(-1, 3) * 7919 % 4096
    k = np.arange(3000)
    number = k * 1009 % (21 * len(F0))
    first = len(F0) * np.array([0, 1, 5])
    group = np.searchsorted(first[1:], number, side="right")
    long = write_stream(replace(header, total_features=3000), ints, F0, group, number - first[group],
                        (k[:, None] * 7 + np.arange(8) * 5) % 13 - 6)
    assert sha256(long).hexdigest()[:16] == "869ce9dcefa53a02"
    assert len(read_stream(long, strict=True).group) == 3000


@settings(deadline=None, max_examples=60)
@given(st.data())
def test_damage_to_version_2_ends_in_an_error_or_a_shorter_read(data):
    whole = bytes.fromhex(FROZEN_2)
    damaged = bytearray(whole[:data.draw(st.integers(0, len(whole)))])
    for _ in range(data.draw(st.integers(0, 3)) if damaged else 0):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] ^= data.draw(st.integers(1, 255))
    try:
        read = read_stream(bytes(damaged))
    except StreamError as error:
        assert "Expected" in str(error)
    else:
        assert len(read.group) <= read.header.total_features


def test_plain_python_reads_and_writes_the_same_bytes(tmp_path):
    data = stream(30, across=2)[0]
    (tmp_path / "a").write_bytes(data)
    script = ("import sys; sys.modules['numba'] = None\n"
              "from npm_blender.core.jit import COMPILED\n"
              "from npm_blender.core.bitstream.container import read_stream, write_stream\n"
              f"data = open({str(tmp_path / 'a')!r}, 'rb').read()\n"
              "s = read_stream(data)\n"
              "assert not COMPILED and len(s.group) == 30\n"
              "assert write_stream(s.header, (s.V0 * 4096).astype(int), s.F0, s.group, s.face, s.value) == data\n")
    done = subprocess.run([sys.executable, "-W", "error::RuntimeWarning", "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_each_byte_of_a_large_stream_is_decoded_at_most_once(monkeypatch):
    data, _ = stream(1700, across=9, seed=1)
    payloads, range_decoder = [], packets.range_decoder

    def counting(contexts, weights, payload):
        payloads.append(bytes(payload))
        return range_decoder(contexts, weights, payload)

    monkeypatch.setattr(packets, "range_decoder", counting)
    found = read_stream(data)
    assert len(found.group) == 1700 and not found.truncated and len(data) > 6000
    assert len(payloads) == len(found.packet_ends[0]) - 1 and sum(map(len, payloads)) < len(data) - found.base_bytes
