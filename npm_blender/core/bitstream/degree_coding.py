"""What region growing codes in nearly every step: the degree of a new vertex, and whether a vertex is an old one.

Both are told from what is known about the gate, eight numbers called `around`: missing faces of its ends a and b, of
the node before a and of the one after b; degrees of a, b and of the third vertex of the gate's face; nodes of the
loop. A vertex of more faces than usual has neighbours of fewer, and several contexts see that, each a part of it (see
`mixing`).
"""
import numpy as np

from ..jit import njit
from .mixing import Mixer, code_mixed, new_mixer
from .range_coder import code_exp_golomb

_STEPS = 12                 # degrees 3..14 by contexts, above by Exp-Golomb
_SLOTS = 6
_ENDS, _SUM, _ANY, _SIDES, _DEGREES, _APEX = 0, 768, 960, 972, 1740, 2940   # first contexts of a degree
_OLD = 4668                 # and of whether a vertex is old: 64, 64, 72, 100, 144 and 1 of them
_CONTEXTS = _OLD + 445
_OLD_ROW, _OLD_SECOND, _SECOND, _ROWS = 12, 13, 14, 30
_START = 12_000             # weight of each context at first
# chances of a degree of more than 3, 4, ... 14, of those that have so many, in 2^-22: where the contexts begin
_PRIOR = (4_139_000, 3_809_000, 3_105_000, 2_189_000, 1_837_000, 1_613_000, 1_760_000, 2_059_000, 2_161_000, 2_271_000,
          2_500_000, 2_500_000)
_OLD_PRIOR = 60_000
_TRUST = 2                  # bits that a beginning counts for


def new_degree_mixer() -> Mixer:
    """The mixer of `code_degree` and `code_is_old`, as it is at the start of a stream."""
    weights = np.zeros((_ROWS, _SLOTS + 1), np.int64)
    weights[:_OLD_SECOND, :_SLOTS] = _START
    mixer = new_mixer(weights, _CONTEXTS, _SLOTS, 255)
    mixer.contexts[:_OLD, 0] = np.resize(_PRIOR, _OLD)
    mixer.contexts[_OLD:, 0] = _OLD_PRIOR
    mixer.contexts[:, 1] = _TRUST
    return mixer


def new_surroundings() -> np.ndarray:
    """Room for what is known about a gate: (8,) int64."""
    return np.zeros(8, np.int64)


@njit
def code_degree(coder, mixer, degree, around):
    """Code the degree >= 3 of a vertex beyond the gate."""
    a, b, near, far = min(around[0], 7), min(around[1], 7), min(around[2], 7), min(around[3], 7)
    missing = min(around[0] + around[1], 15)
    slots, second = mixer.slots, _SECOND + missing
    for t in range(_STEPS):
        slots[0] = _ENDS + _STEPS * (8 * a + b) + t
        slots[1] = _SUM + _STEPS * missing + t
        slots[2] = _ANY + t
        slots[3] = _SIDES + _STEPS * (8 * near + far) + t
        slots[4] = _DEGREES + _STEPS * (10 * min(around[4], 9) + min(around[5], 9)) + t
        slots[5] = _APEX + _STEPS * (12 * min(around[6], 11) + min(missing, 11)) + t
        if code_mixed(coder, mixer, 1 if degree > 3 + t else 0, t, second) == 0:
            return 3 + t
    return 3 + _STEPS + code_exp_golomb(coder, degree - 3 - _STEPS)


@njit
def code_is_old(coder, mixer, old, around):
    """Code whether the vertex beyond the gate is one that the region has met."""
    slots = mixer.slots
    slots[0] = _OLD + 8 * (min(around[0], 8) - 1) + min(around[1], 8) - 1
    slots[1] = _OLD + 64 + 8 * (min(around[2], 8) - 1) + min(around[3], 8) - 1
    slots[2] = _OLD + 128 + min(around[7], 71)
    slots[3] = _OLD + 200 + 10 * min(around[4], 9) + min(around[5], 9)
    slots[4] = _OLD + 300 + 12 * min(around[2], 11) + min(around[3], 11)
    slots[5] = _OLD + 444
    return code_mixed(coder, mixer, old, _OLD_ROW, _OLD_SECOND)
