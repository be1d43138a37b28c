"""One coordinate as a few binary decisions, each with the chances that three distributions give it.

The distributions are those of the two predictions (`position_spread`) and the mixture of the candidates
(`position_candidates`). Decisions start at the likeliest candidate and are as fine as the mixture's spread: is it
this lattice step (asked only where the spread is small); on which side; beyond how many buckets, which double in
width; where in the bucket. A distribution's opinion is the logarithm of the odds between the two parts; `mixing`
weighs the opinions with those of contexts.
"""
from typing import NamedTuple

import numpy as np

from ..jit import njit
from .fixed_point import ONE_TAIL, log2
from .header import MAX_BITS
from .mixing import LARGEST, Mixer, code_mixed, new_mixer
from .position_candidates import below
from .position_guess import PREDICTORS
from .range_coder import ONE, code_probability

LIMIT = 1 << MAX_BITS + 2   # coordinates lie in -LIMIT .. LIMIT - 1
EXPERTS = PREDICTORS + 1
_SAME, _SIDE, _HALF, _BUCKET, _INSIDE, _DEEPER = 0, 1, 2, 3, 11, 19  # what is decided: rows of the mixer
_BUCKETS = 8                # contexts for so many buckets
_NODES = 20
_SCALES = 16                # half octaves of the spread, from half a lattice step on
_SMALL = (9 << 8) + 128     # up to this logarithm of the spread the lattice step itself is asked first
_NATS = 177                 # 256 ln 2
_BY_SCALE, _BY_PLACE, _BY_BEFORE, _BY_LOOK = 0, 16 * _NODES, 28 * _NODES, 44 * _NODES   # first contexts
_CONTEXTS = 108 * _NODES
ROWS = _NODES + _SCALES
WIDTH = EXPERTS + 5         # columns of the mixer: experts, four contexts, bias
# places in `Scene.now`
PLACE, BEFORE, LOOK, SCALE = range(4)


class Scene(NamedTuple):
    """Distributions and contexts of one coordinate. All int64.

    centre, inverse (2,): predictions and 2^32 over their spreads; low, middle, high (3,): chance of lying below the interval,
    below where it is cut, and below its end, times 2^30; now (4,), see PLACE: number of flaps and axis; how far the coordinate
    before was, for the first of a vertex 8 more than the farthest of the vertex before; how even the neighbours are; half
    octaves of the spread; reach (1,): how far the last one was, 0 for exact, to 7.
    """

    centre: np.ndarray
    inverse: np.ndarray
    low: np.ndarray
    middle: np.ndarray
    high: np.ndarray
    now: np.ndarray
    reach: np.ndarray


def new_scene() -> Scene:
    """Room for one coordinate."""
    return Scene(*(np.zeros(n, np.int64) for n in (PREDICTORS, PREDICTORS, EXPERTS, EXPERTS, EXPERTS, 4, 1)))


def new_value_mixer(weights: np.ndarray) -> Mixer:
    """A mixer for coordinates that begins with these weights (36, 8)."""
    return new_mixer(weights, _CONTEXTS, 4)


@njit(inline="always")
def _cut(scene, candidates, axis, x, chances):
    """The chances of lying below lattice step x, into chances (3,)."""
    at = (x << 8) - 128
    for p in range(PREDICTORS):
        chances[p] = below(at - scene.centre[p], scene.inverse[p])
    total, inverse = 0, candidates.numbers[2]
    for j in range(candidates.numbers[0]):
        if candidates.shares[j] > 0:
            total += candidates.shares[j] * below(at - candidates.places[axis, j], inverse)
    chances[PREDICTORS] = total >> 16


@njit(inline="always")
def _odds(one, other):
    """256 ln of the odds between two chances."""
    return min(max((log2(max(one, 0) + 1) - log2(max(other, 0) + 1)) * _NATS >> 8, -LARGEST), LARGEST)


@njit(inline="always")
def _decide(coder, mixer, now, node, bit):
    """Code a bit; the experts' opinions are there already."""
    slots = mixer.slots
    slots[0] = _BY_SCALE + 16 * node + now[SCALE]
    slots[1] = _BY_PLACE + 12 * node + now[PLACE]
    slots[2] = _BY_BEFORE + 16 * node + now[BEFORE]
    slots[3] = _BY_LOOK + 64 * node + now[LOOK]
    return code_mixed(coder, mixer, bit, node, _NODES + now[SCALE])


@njit(inline="always")
def _keep(scene, upper):
    """Go on with the upper or the lower part of the interval."""
    for e in range(EXPERTS):
        if upper:
            scene.low[e] = scene.middle[e]
        else:
            scene.high[e] = scene.middle[e]


@njit(inline="always")
def _code_side(coder, mixer, scene, candidates, axis, start, value):
    """First decisions. Returns 0 for `start` itself, 1 for above (or for `start` and above), -1 for below."""
    low, middle, high, opinions = scene.low, scene.middle, scene.high, mixer.opinions
    _cut(scene, candidates, axis, start, middle)
    if candidates.numbers[1] < _SMALL:
        _cut(scene, candidates, axis, start + 1, low)
        for e in range(EXPERTS):
            opinions[e] = _odds(low[e] - middle[e], ONE_TAIL - low[e] + middle[e])
        if _decide(coder, mixer, scene.now, _SAME, 1 if value == start else 0):
            return 0
        for e in range(EXPERTS):
            opinions[e] = _odds(ONE_TAIL - low[e], middle[e])
        upper = _decide(coder, mixer, scene.now, _SIDE, 1 if value > start else 0)
    else:
        for e in range(EXPERTS):
            low[e] = middle[e]
            opinions[e] = _odds(ONE_TAIL - middle[e], middle[e])
        upper = _decide(coder, mixer, scene.now, _HALF, 1 if value >= start else 0)
    for e in range(EXPERTS):
        high[e] = ONE_TAIL
        if not upper:
            high[e], low[e] = middle[e], 0
    return 1 if upper else -1


@njit(inline="always")
def _is_farther(coder, mixer, scene, candidates, axis, x, side, node, value):
    """Whether the value is on the far side of the cut at x, seen from the start; the interval becomes the part that holds it."""
    _cut(scene, candidates, axis, x, scene.middle)
    for e in range(EXPERTS):
        above = _odds(scene.high[e] - scene.middle[e], scene.middle[e] - scene.low[e])
        mixer.opinions[e] = above if side > 0 else -above
    farther = _decide(coder, mixer, scene.now, node, 1 if (value >= x) == (side > 0) else 0)
    _keep(scene, (farther == 1) == (side > 0))
    return farther


@njit
def code_value(coder, mixer, scene, candidates, axis, start, value):
    """Code a coordinate, counted from lattice step `start`. Returns it; it is within the limits, whatever the data are."""
    start = min(max(start, 2 - LIMIT), LIMIT - 3)
    log = candidates.numbers[1]
    scene.now[SCALE] = min(max((log >> 7) - 16 + 1, 0), _SCALES - 1)
    side = _code_side(coder, mixer, scene, candidates, axis, start, value)
    scene.reach[0] = 0
    if side == 0:
        return start
    low, high = start, LIMIT
    if side < 0:
        low, high = -LIMIT, start
    elif log < _SMALL:
        low = start + 1
    width, bucket = 1 << max((log >> 8) - 8, 0), 0
    while width < high - low:
        x = low + width if side > 0 else high - width
        farther = _is_farther(coder, mixer, scene, candidates, axis, x, side, _BUCKET + min(bucket, _BUCKETS - 1), value)
        if (farther == 1) == (side > 0):
            low = x
        else:
            high = x
        if farther == 0:
            break
        bucket += 1
        if bucket > 1:
            width <<= 1
    scene.reach[0] = min(bucket + 1, 7)
    depth = 0
    while high - low > 1:
        x = (low + high) >> 1
        if depth < 2:
            node = _INSIDE + min(bucket, 7) if depth == 0 else _DEEPER
            upper = (_is_farther(coder, mixer, scene, candidates, axis, x, side, node, value) == 1) == (side > 0)
        else:
            upper = code_probability(coder, 1 if value >= x else 0, ONE >> 1) == 1
        if upper:
            low = x
        else:
            high = x
        depth += 1
    return low
