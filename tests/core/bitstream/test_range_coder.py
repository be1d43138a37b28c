import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.bitstream.range_coder import (
    code_bit,
    code_probability,
    code_raw,
    code_signed,
    code_uniform,
    finish_encoding,
    new_contexts,
    new_weights,
    range_decoder,
    range_encoder,
)
from npm_blender.core.bitstream.varint import read_varint, write_varint
from npm_blender.core.jit import njit

LIMIT = 6


@njit
def code_all(coder, values):
    """Signed numbers in place, contexts by the size of the one before."""
    before = 0
    for a in range(len(values)):
        near = (1 + min(abs(before), 3)) * (LIMIT + 1)
        values[a] = code_signed(coder, values[a], 0, near, near, 0, LIMIT)
        before = values[a]


@njit
def code_plain(coder, values, counts):
    """Per row a raw number, a uniform one and a bit of fixed probability, in place."""
    for a in range(len(values)):
        values[a, 0] = code_raw(coder, values[a, 0], 20)
        values[a, 1] = code_uniform(coder, values[a, 1], counts[a])
        values[a, 2] = code_probability(coder, values[a, 2], 1 + 4_000_000 * (a % 2))


def models():
    return new_contexts(5 * (LIMIT + 1)), new_weights(LIMIT + 1)


def encode(values):
    coder = range_encoder(*models(), 32 + 24 * len(values))
    code_all(coder, np.array(values, np.int64))
    return finish_encoding(coder)


def decode(data, count):
    out = np.zeros(count, np.int64)
    code_all(range_decoder(*models(), data), out)
    return out


@settings(deadline=None, max_examples=60)
@given(st.lists(st.one_of(st.integers(-3, 3), st.integers(-(2**30), 2**30)), max_size=200))
def test_signed_numbers_come_back(values):
    assert decode(encode(values), len(values)).tolist() == values


@settings(deadline=None, max_examples=60)
@given(st.lists(st.tuples(st.integers(0, 2**20 - 1), st.integers(1, 10**6), st.integers(0, 1)), max_size=100), st.data())
def test_plain_numbers_come_back(rows, data):
    counts = np.array([r[1] for r in rows], np.int64)
    values = np.array([(r[0], data.draw(st.integers(0, r[1] - 1)), r[2]) for r in rows], np.int64).reshape(-1, 3)
    coder = range_encoder(*models(), 64 + 16 * len(rows))
    code_plain(coder, values.copy(), counts)
    out = np.zeros_like(values)
    code_plain(range_decoder(*models(), finish_encoding(coder)), out, counts)
    assert (out == values).all()


@pytest.mark.parametrize("scale", [0.3, 1.0, 3.0])
def test_length_is_near_the_entropy(scale):
    values = np.rint(np.random.default_rng(0).laplace(0, scale, 20_000)).astype(np.int64)
    p = np.unique(values, return_counts=True)[1] / len(values)
    bits = -len(values) * (p * np.log2(p)).sum()
    assert 8 * len(encode(values)) < 1.03 * bits + 64


def test_short_messages_have_no_tail():
    assert encode([]) == b""
    assert len(encode([0] * 10)) <= 1
    assert len(encode([0] * 5000)) <= 12


def test_carry_runs_through_written_bytes():
    contexts, weights = models()

    for seed in range(200):  # very likely bits with rare unlikely ones push the low end over long runs of 255
        bits = (np.random.default_rng(seed).random(400) < 0.02).astype(np.int64)
        rows = np.stack([np.full(400, 2**20 - 1), np.zeros(400, int), bits], 1)
        coder = range_encoder(contexts, weights, 4000)
        code_plain(coder, rows.copy(), np.ones(400, np.int64))
        out = np.zeros_like(rows)
        code_plain(range_decoder(contexts, weights, finish_encoding(coder)), out, np.ones(400, np.int64))
        assert (out == rows).all()


@settings(deadline=None, max_examples=40)
@given(st.binary(max_size=60))
def test_any_bytes_decode_to_bounded_numbers(data):
    assert (np.abs(decode(data, 50)) < 2**31 + LIMIT).all()


def test_too_small_a_buffer_is_reported():
    coder = range_encoder(*models(), 3)
    code_plain(coder, np.full((50, 3), 1), np.full(50, 9))
    with pytest.raises(ValueError, match="needs"):
        finish_encoding(coder)


def test_contexts_learn_and_stay_in_range():
    contexts, weights = models()
    coder = range_encoder(contexts, weights, 1000)
    for _ in range(3000):
        code_bit(coder, 1, 0, 1, 2, 0)
    assert contexts[0, 0] > 0.99 * 2**22 and contexts[0, 0] < 2**22 and contexts[0, 1] == contexts[0, 2]
    assert len(finish_encoding(coder)) < 30


@given(st.integers(0, 2**63 - 1), st.binary(max_size=3))
def test_varint_comes_back(value, around):
    assert read_varint(around + write_varint(value) + around, len(around)) == (value, len(around) + len(write_varint(value)))
