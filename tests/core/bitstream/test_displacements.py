"""Integers of a displaced surface: they come back, any prefix gives the first of them, and what is quiet costs nothing."""
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.bitstream import (
    around,
    canonical_order,
    decode_displacements,
    displacements,
    encode_displacements,
)
from npm_blender.core.bitstream.header import MAX_LEVELS
from npm_blender.core.mesh import hierarchy
from tests.core.bitstream.samples import some_table
from tests.meshes.base_meshes import TETRAHEDRON, double_torus, grid, sphere

BASES = {"closed": sphere(2)[1], "open": grid(3, 4), "handles": double_torus(), "a tetrahedron": TETRAHEDRON,
         "one face": np.array([[0, 1, 2]])}


def shape(name, levels):
    """What both sides know: vertices around, and the first of each level."""
    F0 = canonical_order(BASES[name], int(BASES[name].max()) + 1).F
    lods = hierarchy(F0, int(F0.max()) + 1, levels)
    return around(lods), np.array([0, *(level.n for level in lods)]), lods


def first_numbers(table, coded, first, count):
    """The table of a reader that has the first `count` numbers."""
    out, value = np.zeros_like(table), np.zeros(table.shape[1], np.int64)
    for s in range(len(table)):
        value = 2 * value
        for level in np.flatnonzero(coded[s]):
            now = slice(first[level], min(first[level + 1], first[level] + count))
            value[now] = table[s, now]
            count -= now.stop - now.start
        out[s] = value
    return out


@settings(max_examples=40)
@given(st.sampled_from(sorted(BASES)), st.integers(0, 3), st.integers(0, 5), st.integers(0, 2**31))
def test_integers_come_back(name, levels, stages, seed):
    near, first, _ = shape(name, levels)
    table = some_table(first, stages, np.random.default_rng(seed))
    data, sent = encode_displacements(table, near, first)
    found = decode_displacements(data, stages, near, first)
    assert np.array_equal(found.table, table) and np.array_equal(found.coded, sent.coded) and found.numbers == sent.numbers
    assert np.array_equal(found.ends, sent.ends)
    assert found.numbers == (np.diff(first) * found.coded).sum()


@pytest.mark.parametrize("size", [14, 15, 40, 10**6, 2**29])
def test_large_integers_come_back(size):
    near, first, _ = shape("open", 1)
    table = np.random.default_rng(1).integers(-size, size + 1, (2, first[-1]))
    table[1] += 2 * table[0]
    assert np.array_equal(decode_displacements(encode_displacements(table, near, first)[0], 2, near, first).table, table)


def test_every_prefix_gives_the_first_numbers_and_no_byte_comes_too_early():
    near, first, _ = shape("closed", 2)
    table = some_table(first, 3, np.random.default_rng(5), quiet=0.2)
    data, sent = encode_displacements(table, near, first)
    counts = []
    for cut in range(len(data) + 1):
        found = decode_displacements(data[:cut], 3, near, first)
        assert np.array_equal(found.table, first_numbers(table, sent.coded, first, found.numbers))
        counts.append(found.numbers)
    assert counts == sorted(counts) and counts[-1] == sent.numbers
    for k, end in enumerate(sent.ends):
        number = min(k * sent.group, sent.numbers)
        assert counts[end] >= number and (not number or counts[end - 1] < number)


@settings(max_examples=50)
@given(st.binary(max_size=300), st.integers(0, 6))
def test_any_bytes_are_some_numbers(data, stages):
    near, first, _ = shape("open", 2)
    found = decode_displacements(data, stages, near, first)
    assert found.table.shape == (stages, first[-1]) and 0 <= found.numbers <= found.table.size
    assert (np.diff(found.ends) >= 0).all() and found.ends[-1] <= len(data)


def test_levels_in_which_nothing_changes_cost_next_to_nothing():
    near, first, _ = shape("handles", 3)
    table = np.zeros((8, first[-1]), np.int64)
    data, sent = encode_displacements(table, near, first)
    assert sent.numbers == 0 and not sent.coded.any() and len(data) <= 8
    table[0, :first[1]] = 1
    table = np.cumprod([table[0] * 0 + 1] + [table[0] * 0 + 2] * 7, 0) * table[0]
    data, sent = encode_displacements(table, near, first)
    assert sent.numbers == first[1] and sent.coded.sum() == 1


def test_neighbours_that_are_alike_cost_less_than_strangers():
    near, first, lods = shape("handles", 3)
    rng = np.random.default_rng(0)
    busy = np.zeros(first[-1], np.int64)
    busy[: first[-1] // 2] = rng.integers(-3, 4, first[-1] // 2)
    patch = np.zeros((1, first[-1]), np.int64)
    for level in range(4):
        n = first[level + 1] - first[level]
        patch[0, first[level]:first[level] + n // 8] = rng.integers(-3, 4, n // 8)
    scattered = patch.copy()
    for level in range(4):
        now = slice(first[level], first[level + 1])
        scattered[0, now] = rng.permutation(patch[0, now])
    sizes = [len(encode_displacements(t, near, first)[0]) for t in (patch, scattered)]
    assert sizes[0] < 0.8 * sizes[1]


@pytest.mark.parametrize("name", BASES)
def test_what_is_around_a_vertex_is_near_it_and_on_no_finer_level(name):
    near, first, lods = shape(name, 2)
    level_of = np.searchsorted(first[1:], np.arange(first[-1]), "right")
    v, t = np.nonzero(near >= 0)
    assert near.shape == (first[-1], 8) and near.dtype == np.int32 and near.max() < first[-1]
    assert (level_of[near[v, t]] <= level_of[v]).all() and (near[v, t] != v).all()
    edges = {tuple(sorted(e)) for e in lods[1].edges.tolist()}
    for v in range(first[1], first[2]):
        ends, sides = near[v, 4:6], [u for u in near[v, :4] if u >= 0]
        assert all(tuple(sorted((v, int(u)))) in edges for u in (*ends, *sides))


def test_every_level_that_a_stream_may_have_has_contexts_of_its_own(monkeypatch):
    """In plain Python, an index beyond the contexts or the mixers raises."""
    for name in ("_code_stages", "_code", "_beyond", "_size", "_sign", "code_bit", "code_signed", "code_unsigned"):
        monkeypatch.setattr(displacements, name, getattr(getattr(displacements, name), "py_func", getattr(displacements, name)))
    near = np.full((MAX_LEVELS + 1, 8), -1, np.int32)
    table, first = np.stack([np.arange(1, MAX_LEVELS + 2), np.arange(-2, 2 * MAX_LEVELS, 2)]), np.arange(MAX_LEVELS + 2)
    data, _ = encode_displacements(table, near, first)
    assert np.array_equal(decode_displacements(data, 2, near, first).table, table)
