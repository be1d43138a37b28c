"""One binary decision from many opinions: logistic mixing of any number of adaptive contexts and outside estimates.

`range_coder.code_bit` mixes three contexts; here a bit is coded from `opinions` (logarithms of odds that the caller
computed from a model of its own) and from the contexts whose rows the caller put into `slots`. Two rows of weights
are added, one chosen by what is decided and one by how, so that both learn from every bit. Logistic mixing: Mahoney
2005.
"""
from typing import NamedTuple

import numpy as np

from ..jit import njit
from .logistic_tables import RECIPROCAL, SQUASH, STRETCH
from .range_coder import ENCODE, FLOOR, MODE, ONE, RANGE, _decode_step, _encode_step, new_contexts

RATE = 16                   # of the weights, in 2**-16 of stretched opinion times error
SECOND = 10                 # sixteenths of it for the second row
BIAS = 256                  # the last opinion is always this
LARGEST = 2047              # of an opinion


class Mixer(NamedTuple):
    """What decides bits. All int64.

    weights (rows, n): 16.16 fixed point; opinions (n,): 256 ln(p / (1 - p)), first those of the caller, then the contexts',
    then `BIAS`; slots (c,): rows of the contexts to ask; contexts (rows, 3): as `range_coder.Coder.contexts`.
    """

    weights: np.ndarray
    opinions: np.ndarray
    slots: np.ndarray
    contexts: np.ndarray


def new_mixer(weights: np.ndarray, contexts: int, slots: int, limit: int = 255) -> Mixer:
    """A fresh mixer: a copy of weights (rows, n) int64, so many contexts, of which `slots` are asked for each bit.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream.mixing import new_mixer
    >>> new_mixer(np.zeros((1, 4), np.int64), contexts=10, slots=2).opinions.tolist()  # one opinion, two contexts, bias
    [0, 0, 0, 256]
    """
    opinions = np.zeros(weights.shape[1], np.int64)
    opinions[-1] = BIAS
    return Mixer(weights.copy(), opinions, np.zeros(slots, np.int64), new_contexts(contexts, limit))


@njit(inline="always")
def code_mixed(coder, mixer, bit, row, second):
    """Code a bit from the mixer's opinions and slots, weighed by the sum of two rows; weights and contexts learn from it."""
    rc, w, opinions, contexts = coder.rc, mixer.weights, mixer.opinions, mixer.contexts
    n, slots = len(opinions), len(mixer.slots)
    first = n - 1 - slots
    for c in range(slots):
        opinions[first + c] = STRETCH[contexts[mixer.slots[c], 0] >> 10]
    x = 0
    for k in range(n):
        x += (w[row, k] + w[second, k]) * opinions[k]
    p = SQUASH[min(max(x >> 16, -LARGEST), LARGEST) + LARGEST + 1]
    bound = (rc[RANGE] * p) >> 16
    if rc[MODE] == ENCODE:
        _encode_step(rc, coder.buf, bound, bit)
    else:
        bit = _decode_step(rc, coder.buf, bound)
    error = (((bit << 16) - p) >> 4) * RATE
    for k in range(n):
        step = (opinions[k] * error + 32768) >> 16
        w[row, k] += step
        w[second, k] += step * SECOND >> 4
    for c in range(slots):
        i = mixer.slots[c]
        seen = contexts[i, 1]
        p = contexts[i, 0] + ((((bit << 22) - contexts[i, 0]) * RECIPROCAL[seen]) >> 16)
        contexts[i, 0] = min(max(p, FLOOR), ONE - FLOOR)
        if seen < contexts[i, 2]:
            contexts[i, 1] = seen + 1
    return bit
