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


def encode_packets(base, levels, group, face, value, crc, passes=0, batches=True):
    return packet_encoder.encode_packets(faces_of(base, levels, passes), Features(group, face, value), crc, batches)


def read_packets(data, at, base, levels, channels, total, crc, passes=0, batches=True):
    return packets.read_packets(data, at, faces_of(base, levels, passes), channels, total, crc, batches)


def decode_packets(data, at, base, levels, channels, total, crc, passes=0, batches=True):
    return packets.decode_packets(data, at, faces_of(base, levels, passes), channels, total, crc, batches)


@pytest.mark.parametrize("batches", [True, False])
def test_the_packets_of_any_prefix_are_those_of_its_features_alone(batches):
    rng = np.random.default_rng(2)
    level, face, value = some_features(len(F0), 2, 1300, rng)
    encoder = packet_encoder.PacketEncoder(faces_of(F0, 2), Features(level, face, value), batches)
    for count in (700, 0, 1300, 1299, 39, 40, 401, 460, 1000, 700):
        alone = encode_packets(F0, 2, level[:count], face[:count], value[:count], 9, batches=batches)
        assert packet_encoder.with_checksums(encoder.packets(count), 9) == alone


def same_packets(packets, level, face, value, batches=True):
    """The features that arrived are those sent, batch by batch, inside a batch sorted by level and face."""
    at = 0
    for sizes in packet_sizes(len(level), batches):
        stop = at + sum(sizes)
        order = at + np.lexsort([face[at:stop], level[at:stop]])
        order = order[:max(len(packets.group) - at, 0)]
        came = slice(at, at + len(order))
        assert np.array_equal(packets.group[came], level[order]) and np.array_equal(packets.face[came], face[order])
        assert np.array_equal(packets.value[came], value[order])
        at = stop


def flat(total, batches=True):
    return [size for batch in packet_sizes(total, batches) for size in batch]


@given(st.integers(0, 40_000), st.booleans())
def test_packets_end_at_40_and_400_features(total, batches):
    sizes = flat(total, batches)
    ends = np.cumsum(sizes)
    assert sum(sizes) == total and all(s > 0 for s in sizes)
    for stop in (20, 40, 80, 400):
        assert total < stop or stop in ends
    assert len(ends) < 60


@given(st.integers(0, 40_000))
def test_batches_are_of_whole_packets_and_end_at_40_and_400_features(total):
    assert flat(total) == flat(total, batches=False)
    assert all(len(batch) == 1 for batch in packet_sizes(total, batches=False))
    ends = np.cumsum([sum(batch) for batch in packet_sizes(total)])
    for stop in (20, 40, 400):
        assert total < stop or stop in ends
    assert all(len(batch) <= BATCH for batch in packet_sizes(total)[3:])


def test_sorting_inside_batches_saves_bytes():
    level, face, value = some_features(400, 3, 3000, np.random.default_rng(0))
    with_batches, without = (sum(map(len, encode_packets(F0, 3, level, face, value, 0, batches=b))) for b in (True, False))
    assert with_batches < 0.97 * without


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 900), st.integers(0, 2**32 - 1), st.booleans())
def test_streams_with_and_without_batches_come_back(count, seed, batches):
    level, face, value = some_features(400, 2, count, np.random.default_rng(seed))
    data = b"".join(encode_packets(F0, 2, level, face, value, 3, batches=batches))
    same_packets(decode_packets(data, 0, F0, 2, 8, len(level), 3, batches=batches), level, face, value, batches)
    cut = data[:len(data) * 2 // 3]
    same_packets(decode_packets(cut, 0, F0, 2, 8, len(level), 3, batches=batches), level, face, value, batches)


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
    same_packets(decode_packets(data, 0, OPEN, 3, 8, len(level), 0), level, face, value)


def test_every_prefix_gives_its_whole_packets():
    level, face, value = some_features(len(OPEN), 3, 90, np.random.default_rng(0))
    data = b"".join(encode_packets(OPEN, 3, level, face, value, 0))
    ends = decode_packets(data, 0, OPEN, 3, 8, 90, 0).bytes
    for cut in range(len(data)):
        packets = decode_packets(data[:cut], 0, OPEN, 3, 8, 90, 0)
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
        with pytest.raises(StreamError, match=f"at byte {third},"):
            decode_packets(data, 0, OPEN, 3, 8, 90, 0)
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
        faces = faces_of(base, 3, False)
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


def some_offsets(F0, passes, count, seed, level_count=2):
    """Latents of a few faces, then offsets of random faces in each pass: group, face, value in the order of sending."""
    random = np.random.default_rng(seed)
    levels = hierarchy(F0, int(F0.max()) + 1, level_count - 1)
    group, face, value = (list(a) for a in some_features(len(F0), level_count, 10, random))
    for p in range(1, passes + 1):
        for i, level in enumerate(levels):
            edges = np.rint(random.laplace(0, 1.5, len(level.edges))).astype(int)
            for f in random.permutation(len(level.F))[:count]:
                group.append(p * level_count + i)
                face.append(f)
                value.append([*edges[level.edge_of[3 * f:3 * f + 3]], 0, 0, 0, 0, 0])
    mixed = random.permutation(len(group))
    return np.array(group)[mixed], np.array(face)[mixed], np.array(value)[mixed]


@settings(deadline=None, max_examples=25)
@given(st.integers(1, 3), st.integers(0, 60), st.booleans(), st.integers(0, 2**32 - 1))
def test_offsets_come_back(passes, count, border, seed):
    base = OPEN if border else F0
    group, face, value = some_offsets(base, passes, count, seed)
    data = b"".join(encode_packets(base, 2, group, face, value, 5, passes))
    packets = decode_packets(data, 0, base, 2, 8, len(group), 5, passes)
    same_packets(packets, group, face, value)
    for cut in np.random.default_rng(seed).integers(0, len(data), 3):
        part = decode_packets(data[:cut], 0, base, 2, 8, len(group), 5, passes)
        k = part.features[-1]
        assert np.array_equal(part.value, packets.value[:k]) and np.array_equal(part.group, packets.group[:k])


def test_an_edge_costs_nothing_the_second_time():
    """All faces of a closed mesh have twice as many sides as edges; the values of half of the sides are free."""
    levels = hierarchy(F0, 200, 0)
    edges = np.random.default_rng(0).integers(-6, 7, len(levels[0].edges))
    value = np.pad(edges[levels[0].edge_of].reshape(-1, 3), ((0, 0), (0, 5)))
    group, face = np.ones(len(F0), int), np.arange(len(F0))
    bits = 8 * sum(map(len, encode_packets(F0, 1, group, face, value, 0, 1)))
    nothing = 8 * sum(map(len, encode_packets(F0, 1, group, face, 0 * value, 0, 1)))
    assert bits - nothing < 1.2 * len(edges) * np.log2(13)


def test_groups_beyond_the_passes_are_refused():
    for passes, group in ((0, 3), (1, 6)):
        with pytest.raises(StreamError, match="levels"):
            encode_packets(OPEN, 3, np.array([group]), np.array([0]), np.zeros((1, 8), int), 0, passes)
