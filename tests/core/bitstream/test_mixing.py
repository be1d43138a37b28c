import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.bitstream.mixing import code_mixed, new_mixer
from npm_blender.core.bitstream.range_coder import (
    finish_encoding,
    new_contexts,
    new_weights,
    range_decoder,
    range_encoder,
)


def mixer():
    return new_mixer(np.full((3, 4), 16_000), 10, 2)


def code(coder, bits, opinion):
    m, out = mixer(), []
    for bit in bits:
        m.opinions[0] = opinion(bit)
        m.slots[:] = len(out) % 3, 5
        out.append(code_mixed(coder, m, bit, 0, 1 + len(out) % 2))
    return out, m


def nothing():
    return new_contexts(0), new_weights(0)


@settings(deadline=None, max_examples=40)
@given(st.lists(st.integers(0, 1), max_size=200), st.integers(-2047, 2047))
def test_bits_come_back(bits, opinion):
    coder = range_encoder(*nothing(), 64 + 2 * len(bits))
    code(coder, bits, lambda bit: opinion)
    assert code(range_decoder(*nothing(), finish_encoding(coder)), [0] * len(bits), lambda bit: opinion)[0] == bits


def test_an_opinion_that_is_right_gets_weight():
    bits = np.random.default_rng(0).integers(0, 2, 2000).tolist()
    coder = range_encoder(*nothing(), 4000)
    _, m = code(coder, bits, lambda bit: 300 if bit else -300)
    assert m.weights[0, 0] > 60_000 and len(finish_encoding(coder)) < 100
