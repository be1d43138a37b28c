"""Adaptive binary range coder, integer-exact, with logistic mixing of three contexts per binary decision.

Each `code_*` function both encodes and decodes: with `coder.rc[MODE] == ENCODE` it writes the value that it is given,
otherwise it ignores that value and reads one; either way it returns the value. So a model is written once, and its two
directions cannot drift apart. State is four integer arrays, see `Coder`; contexts and mixers are rows, passed by index.

The probability that a bit is 1, in three steps (docs/format.md has the same in full):
    every context keeps p (22 bits) and a count n; s_k = stretch(p_k) = 256 ln(p / (1 - p))
    p = squash(sum_k w_k s_k), weights from the mixer row (16.16 fixed point)
    after the bit: w_k += s_k * error, p_k += (bit - p_k) / (n_k + 2), n_k rises to the row's limit

Range coding: Martin 1979; logistic mixing: Mahoney 2005.
"""
from typing import NamedTuple

import numpy as np

from ..jit import njit
from .logistic_tables import RECIPROCAL, SQUASH, STRETCH

MODE, LOW, RANGE, POSITION, END = 0, 1, 2, 3, 4
DECODE, ENCODE = 0, 1
TOP = 1 << 24
ONE = 1 << 22               # probability one of a context
FLOOR = 1 << 7              # a context's probability stays this far from 0 and 1
INPUTS = 3
DEFAULT_WEIGHT = 24_000     # 16.16: three inputs that agree are trusted slightly more than each alone
LEARNING_RATE = 10
ESCAPE_BITS = 30            # Exp-Golomb prefix at most: values stay below 2**31


class Coder(NamedTuple):
    """State of a coder.

    rc (5,) int64: MODE, LOW (encoder: interval's low end, decoder: code value minus it), RANGE, POSITION, END;
    buf (n,) uint8: bytes; contexts (c, 3) int64: probability of a one (22 bits), count, count limit;
    weights (m, 3) int64: mixer rows. Contexts and weights may be shared by several coders in turn.
    """

    rc: np.ndarray
    buf: np.ndarray
    contexts: np.ndarray
    weights: np.ndarray


def new_contexts(count: int, limit: int = 255) -> np.ndarray:
    """Fresh contexts (count, 3) int64 with probability 1/2; limit: how much of the past they remember (1..1023).

    >>> from npm_blender.core.bitstream import new_contexts
    >>> new_contexts(2).tolist() == [[2**21, 0, 255], [2**21, 0, 255]]
    True
    """
    return np.tile(np.array([ONE // 2, 0, limit], dtype=np.int64), (count, 1))


def new_weights(count: int) -> np.ndarray:
    """Fresh mixer rows (count, 3) int64: the weights of the three contexts of a bit, 16.16 fixed point.

    >>> from npm_blender.core.bitstream import new_weights
    >>> [round(weight / 2**16, 2) for weight in new_weights(1)[0]]
    [0.37, 0.37, 0.37]
    """
    return np.full((count, INPUTS), DEFAULT_WEIGHT, dtype=np.int64)


def range_encoder(contexts: np.ndarray, weights: np.ndarray, capacity: int) -> Coder:
    """A coder that writes at most `capacity` bytes; see `finish_encoding`.

    contexts, weights: from `new_contexts` and `new_weights`; they learn, so the decoder is given fresh ones of its own.

    >>> from npm_blender.core.bitstream import code_raw, finish_encoding, new_contexts, new_weights, range_encoder
    >>> coder = range_encoder(new_contexts(1), new_weights(1), capacity=8)
    >>> code_raw(coder, 0b1011, 4), finish_encoding(coder).hex()
    (11, '40')
    """
    rc = np.array([ENCODE, 0, (1 << 32) - 1, 0, capacity], dtype=np.int64)
    return Coder(rc, np.zeros(capacity + 8, dtype=np.uint8), contexts, weights)


def range_decoder(contexts: np.ndarray, weights: np.ndarray, data: bytes) -> Coder:
    """A coder that reads `data`; beyond its end it reads zeros, as the encoder drops trailing zeros.

    >>> from npm_blender.core.bitstream import code_raw, new_contexts, new_weights, range_decoder
    >>> code_raw(range_decoder(new_contexts(1), new_weights(1), b"\\x40"), 0, 4)  # the 0 is ignored
    11
    """
    buf = np.frombuffer(bytes(data) + b"\0\0\0\0", dtype=np.uint8).copy()
    rc = np.array([DECODE, int.from_bytes(buf[:4].tobytes(), "big"), (1 << 32) - 1, 4, len(data)], dtype=np.int64)
    return Coder(rc, buf, contexts, weights)


def finish_encoding(coder: Coder) -> bytes:
    """End an encoder: the shortest bytes inside the final interval, without trailing zeros.

    >>> from npm_blender.core.bitstream import finish_encoding, new_contexts, new_weights, range_encoder
    >>> finish_encoding(range_encoder(new_contexts(1), new_weights(1), capacity=8))
    b''
    """
    rc = coder.rc
    if rc[POSITION] > rc[END]:  # the caller's bound was wrong: a bug, not an input
        raise ValueError(f"Range coder needs {rc[POSITION]} bytes, was given {rc[END]}")
    low, width = int(rc[LOW]), int(rc[RANGE])
    for shift in range(32, -1, -1):
        value = -(-low >> shift) << shift
        if value < low + width:
            break
    head = int.from_bytes(coder.buf[: rc[POSITION]].tobytes(), "big")
    total = (head << 32) + value
    return total.to_bytes(int(rc[POSITION]) + 5, "big")[1:].rstrip(b"\0")


@njit
def _encode_step(rc, buf, bound, bit):
    """Narrow the interval to its first `bound` (bit 1) or to the rest (bit 0); write the bytes that only a carry can change."""
    if bit:
        rc[RANGE] = bound
    else:
        rc[LOW] += bound
        rc[RANGE] -= bound
    if rc[LOW] >> 32:
        rc[LOW] &= 0xFFFFFFFF
        i = min(rc[POSITION], rc[END]) - 1
        while buf[i] == 255:
            buf[i] = 0
            i -= 1
        buf[i] += 1
    while rc[RANGE] < TOP:
        if rc[POSITION] < rc[END]:
            buf[rc[POSITION]] = rc[LOW] >> 24
        rc[POSITION] += 1
        rc[LOW] = (rc[LOW] & 0xFFFFFF) << 8
        rc[RANGE] <<= 8


@njit
def _decode_step(rc, buf, bound):
    """The bit that the code value falls into; see `_encode_step`."""
    if rc[LOW] < bound:
        bit = 1
        rc[RANGE] = bound
    else:
        bit = 0
        rc[LOW] -= bound
        rc[RANGE] -= bound
    while rc[RANGE] < TOP:
        byte = int(buf[rc[POSITION]]) if rc[POSITION] < rc[END] else 0
        rc[LOW] = (rc[LOW] << 8) | byte
        rc[RANGE] <<= 8
        rc[POSITION] += 1
    return bit


@njit
def code_probability(coder, bit, p):
    """Code a bit whose probability of being 1 is p / 2**22, 0 < p < 2**22; nothing adapts."""
    rc = coder.rc
    bound = (rc[RANGE] * p) >> 22
    if rc[MODE] == ENCODE:
        _encode_step(rc, coder.buf, bound, bit)
        return bit
    return _decode_step(rc, coder.buf, bound)


@njit
def code_bit(coder, bit, i, j, k, w):
    """Code a bit with contexts i, j, k mixed by mixer row w; all of them learn from it.

    p = squash(sum_k w_k stretch(p_k)), see above. Returns the bit; a decoder ignores the one that it is given.

    >>> from npm_blender.core.bitstream import code_bit, finish_encoding, new_contexts, new_weights, range_encoder
    >>> coder = range_encoder(new_contexts(3), new_weights(1), capacity=100)
    >>> bits = [code_bit(coder, 1, 0, 1, 2, 0) for _ in range(800)]
    >>> len(finish_encoding(coder)) < 10  # 800 bits that are all the same
    True
    """
    contexts, weights, rc = coder.contexts, coder.weights, coder.rc
    si, sj, sk = STRETCH[contexts[i, 0] >> 10], STRETCH[contexts[j, 0] >> 10], STRETCH[contexts[k, 0] >> 10]
    x = (weights[w, 0] * si + weights[w, 1] * sj + weights[w, 2] * sk) >> 16
    p = SQUASH[min(max(x, -2047), 2047) + 2048]
    bound = (rc[RANGE] * p) >> 16
    if rc[MODE] == ENCODE:
        _encode_step(rc, coder.buf, bound, bit)
    else:
        bit = _decode_step(rc, coder.buf, bound)
    error = (((bit << 16) - p) >> 4) * LEARNING_RATE
    weights[w, 0] += (si * error + 32768) >> 16
    weights[w, 1] += (sj * error + 32768) >> 16
    weights[w, 2] += (sk * error + 32768) >> 16
    for c in (i, j, k):
        n = contexts[c, 1]
        p = contexts[c, 0] + ((((bit << 22) - contexts[c, 0]) * RECIPROCAL[n]) >> 16)
        contexts[c, 0] = min(max(p, FLOOR), ONE - FLOOR)
        if n < contexts[c, 2]:
            contexts[c, 1] = n + 1
    return bit


@njit
def code_raw(coder, value, bits):
    """Code the low `bits` bits of a value, highest first, all equally likely.

    >>> from npm_blender.core.bitstream import code_raw, new_contexts, new_weights, range_encoder
    >>> code_raw(range_encoder(new_contexts(1), new_weights(1), capacity=8), 1000, 4)  # the low four bits of 1000
    8
    """
    out = 0
    for b in range(bits - 1, -1, -1):
        out = (out << 1) | code_probability(coder, (value >> b) & 1, ONE >> 1)
    return out


@njit
def code_uniform(coder, value, count):
    """Code 0 <= value < count, all equally likely, by halving the interval."""
    low, high = 0, count
    while high - low > 1:
        middle = (low + high) >> 1
        p = min(max(((middle - low) << 22) // (high - low), 1), ONE - 1)
        if code_probability(coder, 1 if value < middle else 0, p):
            high = middle
        else:
            low = middle
    return low


@njit
def code_exp_golomb(coder, value):
    """Code 0 <= value < 2**31 - 1 in about 2 log2(value + 1) + 1 bits, all equally likely. Exp-Golomb: Teuhola 1978."""
    rest, bits = value + 1, 0
    while bits < ESCAPE_BITS and code_probability(coder, 1 if rest >> (bits + 1) else 0, ONE >> 1):
        bits += 1
    return ((1 << bits) | code_raw(coder, rest, bits)) - 1


@njit
def code_unsigned(coder, value, i, j, k, w, limit):
    """Code value >= 0: is it > 0, > 1, .. with contexts i + t, j + t, k + t, mixers w + t; from `limit` Exp-Golomb.

    Uses `limit` rows from each of i, j, k, w. Values stay below 2**31. Exp-Golomb: Teuhola 1978.

    >>> from npm_blender.core.bitstream import *
    >>> coder = range_encoder(new_contexts(4), new_weights(4), capacity=100)
    >>> sent = [code_unsigned(coder, value, 0, 0, 0, 0, 4) for value in (0, 2, 3, 700)]
    >>> coder = range_decoder(new_contexts(4), new_weights(4), finish_encoding(coder))
    >>> [code_unsigned(coder, 0, 0, 0, 0, 0, 4) for _ in range(4)]
    [0, 2, 3, 700]
    """
    for t in range(limit):
        if code_bit(coder, 1 if value > t else 0, i + t, j + t, k + t, w + t) == 0:
            return t
    return limit + code_exp_golomb(coder, value - limit)


@njit
def code_signed(coder, value, i, j, k, w, limit):
    """Code an integer: magnitude as `code_unsigned`, then its sign with contexts i + limit, .. and mixer w + limit.

    Uses limit + 1 rows from each of i, j, k, w.

    >>> from npm_blender.core.bitstream import *
    >>> coder = range_encoder(new_contexts(5), new_weights(5), capacity=100)
    >>> sent = [code_signed(coder, value, 0, 0, 0, 0, 4) for value in (0, -2, 700)]
    >>> coder = range_decoder(new_contexts(5), new_weights(5), finish_encoding(coder))
    >>> [code_signed(coder, 0, 0, 0, 0, 0, 4) for _ in range(3)]
    [0, -2, 700]
    """
    magnitude = code_unsigned(coder, abs(value), i, j, k, w, limit)
    if magnitude == 0:
        return 0
    negative = code_bit(coder, 1 if value < 0 else 0, i + limit, j + limit, k + limit, w + limit)
    return -magnitude if negative else magnitude
