import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import gammaln

from npm_blender.core.bitstream import packet_encoder, packets
from npm_blender.core.bitstream.connectivity import canonical_order
from npm_blender.core.bitstream.packets import BATCH, MAX_VALUE, Features, packet_sizes
from npm_blender.core.bitstream.significance import faces_of
from npm_blender.core.errors import StreamError
from npm_blender.core.mesh.subdivision import hierarchy
from tests.meshes.base_meshes import grid, some_features

F0 = canonical_order(grid(10, 20, True, True), 200).F     # 400 faces, levels of 400, 1600, 6400
OPEN = canonical_order(grid(3, 4), 20).F


def encode_packets(base, levels, level, face, value, crc):
    return packet_encoder.encode_packets(faces_of(base, levels), Features(level, face, value), crc)


def read_packets(data, at, base, levels, channels, total, crc):
    return packets.read_packets(data, at, faces_of(base, levels), channels, total, crc)


def same_packets(packets, level, face, value):
    """The features that arrived are those sent, batch by batch, inside a batch sorted by level and face."""
    at = 0
    for sizes in packet_sizes(len(level)):
        stop = at + sum(sizes)
        order = at + np.lexsort([face[at:stop], level[at:stop]])
        order = order[:max(len(packets.level) - at, 0)]
        came = slice(at, at + len(order))
        assert np.array_equal(packets.level[came], level[order]) and np.array_equal(packets.face[came], face[order])
        assert np.array_equal(packets.value[came], value[order])
        at = stop


def flat(total):
    return [size for batch in packet_sizes(total) for size in batch]


@given(st.integers(0, 40_000))
def test_packets_end_at_40_and_400_features(total):
    sizes = flat(total)
    ends = np.cumsum(sizes)
    assert sum(sizes) == total and all(s > 0 for s in sizes)
    for stop in (20, 40, 80, 400):
        assert total < stop or stop in ends
    assert len(ends) < 60


@given(st.integers(0, 40_000))
def test_batches_end_at_40_and_400_features(total):
    ends = np.cumsum([sum(batch) for batch in packet_sizes(total)])
    for stop in (20, 40, 400):
        assert total < stop or stop in ends
    assert all(len(batch) <= BATCH for batch in packet_sizes(total)[3:])


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 900), st.integers(0, 2**32 - 1))
def test_long_streams_and_their_beginnings_come_back(count, seed):
    level, face, value = some_features(400, 2, count, np.random.default_rng(seed))
    data = b"".join(encode_packets(F0, 2, level, face, value, 3))
    same_packets(read_packets(data, 0, F0, 2, 8, len(level), 3), level, face, value)
    same_packets(read_packets(data[:len(data) * 2 // 3], 0, F0, 2, 8, len(level), 3), level, face, value)


@settings(deadline=None, max_examples=40)
@given(st.integers(1, 4), st.integers(0, 250), st.integers(1, 9), st.integers(0, 2**32 - 1))
def test_features_come_back(levels, count, channels, seed):
    level, face, value = some_features(len(OPEN), levels, count, np.random.default_rng(seed), channels)
    data = b"xyz" + b"".join(encode_packets(OPEN, levels, level, face, value, 77))
    packets = read_packets(data, 3, OPEN, levels, channels, len(level), 77)
    assert packets.features[-1] == len(level) and packets.bytes[-1] == len(data)
    assert packets.corrupt is None and not packets.truncated
    same_packets(packets, level, face, value)


def test_all_faces_and_extreme_values_come_back():
    level, face, value = some_features(len(OPEN), 3, 10**6, np.random.default_rng(0))
    value[5], value[6] = MAX_VALUE, -MAX_VALUE
    data = b"".join(encode_packets(OPEN, 3, level, face, value, 0))
    same_packets(read_packets(data, 0, OPEN, 3, 8, len(level), 0), level, face, value)


def test_every_prefix_gives_its_whole_packets():
    level, face, value = some_features(len(OPEN), 3, 90, np.random.default_rng(0))
    data = b"".join(encode_packets(OPEN, 3, level, face, value, 0))
    ends = read_packets(data, 0, OPEN, 3, 8, 90, 0).bytes
    for cut in range(len(data)):
        packets = read_packets(data[:cut], 0, OPEN, 3, 8, 90, 0)
        assert packets.truncated and packets.features[-1] == [0, 20, 40, 80, 90][np.searchsorted(ends, cut, "right") - 1]
        same_packets(packets, level, face, value)


def test_damage_is_reported_and_what_came_before_is_kept():
    level, face, value = some_features(len(OPEN), 3, 90, np.random.default_rng(0))
    packets = encode_packets(OPEN, 3, level, face, value, 0)
    third = len(packets[0]) + len(packets[1])
    for damaged in (packets[:2] + [packets[2][:9] + bytes([packets[2][9] ^ 4]) + packets[2][10:]] + packets[3:],
                    packets[:2] + packets[3:] + packets[2:3], packets[:2] + [packets[1]] + packets[2:]):
        data = b"".join(damaged)
        read = read_packets(data, 0, OPEN, 3, 8, 90, 0)
        assert read.features[-1] == 40 and f"at byte {third}," in read.corrupt
        same_packets(read, level, face, value)
    whole = b"".join(packets)
    assert "more" in read_packets(whole + b"\0", 0, OPEN, 3, 8, 90, 0).corrupt
    assert "checksum" in read_packets(whole, 0, OPEN, 3, 8, 90, 1).corrupt       # another file's packets


@pytest.mark.parametrize("level, face, value, words", [
    ([0, 0], [1, 1], 1, "twice"), ([0], [len(OPEN)], 1, "beyond"), ([3], [0], 1, "levels"), ([0], [-1], 1, "levels"),
    ([0], [0], MAX_VALUE + 1, "values"),
])
def test_impossible_features_are_refused(level, face, value, words):
    with pytest.raises(StreamError, match=words):
        encode_packets(OPEN, 3, np.array(level), np.array(face), np.full((len(level), 8), value), 0)


def test_twins_are_those_of_the_subdivided_faces():
    for base in (F0, OPEN):
        faces = faces_of(base, 3)
        for i, level in enumerate(hierarchy(base, int(base.max()) + 1, 2)):
            assert np.array_equal(faces.twin[3 * faces.first[i]:3 * faces.first[i + 1]] - 3 * faces.first[i],
                                  level.opposite)


def size_of(level, face, value):
    return 8 * sum(map(len, encode_packets(F0, 3, level, face, value, 0)))


def test_scattered_faces_cost_about_what_chance_demands():
    level, face, value = some_features(400, 3, 2000, np.random.default_rng(0))
    sizes, rest, ideal = flat(2000), 8400, 0.0
    for k in map(sum, packet_sizes(2000)):
        ideal += (gammaln(rest + 1) - gammaln(k + 1) - gammaln(rest - k + 1)) / np.log(2)
        rest -= k
    assert size_of(level, face, value * 0) < 1.05 * ideal + len(sizes) * 48


def test_clustered_faces_cost_less():
    rng = np.random.default_rng(0)
    level, face, value = some_features(400, 3, 2000, rng)
    together = np.concatenate([np.arange(100), 400 + np.arange(400), 2000 + np.arange(1600)])[:2000]
    mixed = np.lexsort([rng.random(2000), np.maximum(together >= 400, 0) + (together >= 2000)])
    number = together[mixed]
    level = np.searchsorted([400, 2000], number, side="right")
    clustered = size_of(level, number - np.array([0, 400, 2000])[level], value * 0)
    scattered = size_of(*some_features(400, 3, 2000, rng)[:2], value * 0)
    assert clustered < 0.75 * scattered


def test_values_cost_about_their_entropy():
    rng = np.random.default_rng(0)
    level, face, _ = some_features(400, 3, 3000, rng)
    value = np.rint(rng.laplace(0, [4, 3, 2, 1, 0.8, 0.5, 0.3, 0.2], (3000, 8))).astype(int)
    ideal = 0.0
    for column in value.T:
        p = np.unique(column, return_counts=True)[1] / len(column)
        ideal -= len(column) * (p * np.log2(p)).sum()
    assert size_of(level, face, value) - size_of(level, face, value * 0) < 1.05 * ideal


def test_each_byte_of_a_large_stream_is_decoded_at_most_once(monkeypatch):
    level, face, value = some_features(400, 3, 1700, np.random.default_rng(1))
    data = b"".join(encode_packets(F0, 3, level, face, value, 0))
    payloads, range_decoder = [], packets.range_decoder

    def counting(contexts, weights, payload):
        payloads.append(bytes(payload))
        return range_decoder(contexts, weights, payload)

    monkeypatch.setattr(packets, "range_decoder", counting)
    found = read_packets(data, 0, F0, 3, 8, 1700, 0)
    assert found.features[-1] == 1700 and not found.truncated
    assert len(payloads) == len(found.features) - 1 and sum(map(len, payloads)) < len(data)
