"""Logarithms, powers, roots and the tail of a distribution in integers: the same on every machine, part of the format.

Logarithms are in steps of 1/256 octave. The distribution is Student's with four degrees of freedom, whose tail is
algebraic: P(t > z) = 1/2 - 3/8 (s - s^3 / 12) with s = z / sqrt(1 + z^2 / 4).
"""
from math import isqrt

import numpy as np

from ..jit import njit

OCTAVE = 256                # steps of a logarithm
TAIL_STEP = 5               # the tail is tabulated at multiples of 2**-5
TAIL_REACH = 64             # up to so many spreads
ONE_TAIL = 1 << 30          # probability one of `tail`
_FINE = 40                  # bits behind the point while a table is made


def _power_table() -> np.ndarray:
    """round(2^16 2^(i / 256)) for i = 0..256, by repeated square roots: (257,) int64."""
    roots = [1 << _FINE + 1]
    for _ in range(8):
        roots.append(isqrt(roots[-1] << _FINE))
    out = []
    for i in range(OCTAVE + 1):
        value = 1 << _FINE
        for bit in range(9):
            if i >> (8 - bit) & 1:
                value = value * roots[bit] >> _FINE
        out.append((value + (1 << _FINE - 17)) >> _FINE - 16)
    return np.array(out, dtype=np.int64)


def _log_table(power: np.ndarray) -> np.ndarray:
    """256 log2 x for x = 0..4095, rounded down, 0 for 0: (4096,) int64."""
    x = np.arange(1 << 12, dtype=np.int64)
    octave = np.array([max(int(i).bit_length() - 1, 0) for i in x], dtype=np.int64)
    return octave * OCTAVE + np.maximum(np.searchsorted(power, (x << 16) >> octave, side="right") - 1, 0)


def _tail_table() -> np.ndarray:
    """2^30 P(t > i / 32) for i = 0..64 * 32 + 1, (2050,) int64, rounded down."""
    one, out = 1 << _FINE, []
    for i in range((TAIL_REACH << TAIL_STEP) + 2):
        # s = z / sqrt(1 + z^2 / 4) with z = i / 32: s^2 = 4 i^2 / (4096 + i^2)
        s = isqrt((4 * i * i << 2 * _FINE) // (4096 + i * i))
        half = 3 * (s - (s * s // one * s // one) // 12) // 8
        out.append(max((one // 2 - half) >> (_FINE - 30), 0))
    return np.array(out, dtype=np.int64)


POWER = _power_table()
LOG = _log_table(POWER)
TAIL = _tail_table()


@njit(inline="always")
def log2(x):
    """256 log2 x, rounded down to a step, for 0 < x < 2**63; of the highest nine to twelve bits. 0 for less.

    >>> from npm_blender.core.bitstream.fixed_point import log2
    >>> log2(1), log2(3), log2(1 << 40)
    (0, 405, 10240)
    """
    shift = 0
    if x >= 1 << 40:
        x >>= 32
        shift = 32
    if x >= 1 << 24:
        x >>= 16
        shift += 16
    if x >= 1 << 16:
        x >>= 8
        shift += 8
    if x >= 1 << 12:
        x >>= 4
        shift += 4
    return LOG[max(x, 0)] + (shift << 8)


@njit(inline="always")
def exp2(x):
    """2**(x / 256) times 2**16, for x up to 45 octaves; 0 far below.

    >>> from npm_blender.core.bitstream.fixed_point import exp2
    >>> exp2(0), exp2(256), exp2(-128)
    (65536, 131072, 46340)
    """
    n, m = x >> 8, POWER[x & 255]
    if n >= 0:
        return m << min(n, 45)
    return m >> min(-n, 63)


@njit
def log_length(x, y, z):
    """256 log2 of the length of an integer vector with components below 2**60; that of length 1/2 for none.

    >>> from npm_blender.core.bitstream.fixed_point import log_length
    >>> log_length(3, 0, -4), log_length(0, 0, 0)  # 5, and 1/2
    (594, -256)
    """
    size, shift = max(abs(x), abs(y), abs(z)), 0
    while size >> shift >= 1 << 30:
        shift += 1
    x, y, z = x >> shift, y >> shift, z >> shift
    square = x * x + y * y + z * z
    if square == 0:
        return -256
    return (log2(square) >> 1) + (shift << 8)


@njit
def square_root(x):
    """Floor of the square root of 0 <= x < 2**62.

    >>> from npm_blender.core.bitstream.fixed_point import square_root
    >>> square_root(80), square_root(81)
    (8, 9)
    """
    if x < 2:
        return x
    r = (exp2((log2(x) >> 1) - 1) >> 16) + 1
    for _ in range(3):
        r = (r + x // r) >> 1
    while r * r > x:
        r -= 1
    while (r + 1) * (r + 1) <= x:
        r += 1
    return r


@njit(inline="always")
def tail(z):
    """P(t > z) 2^30 for z >= 0 in steps of 2**-13, by straight lines between the table's entries.

    >>> from npm_blender.core.bitstream.fixed_point import ONE_TAIL, tail
    >>> tail(0) / ONE_TAIL, round(tail(2 << 13) / ONE_TAIL, 4)
    (0.5, 0.0581)
    """
    i = z >> 8
    if i >= TAIL_REACH << TAIL_STEP:
        return TAIL[TAIL_REACH << TAIL_STEP]
    return TAIL[i] + (((TAIL[i + 1] - TAIL[i]) * (z & 255)) >> 8)
