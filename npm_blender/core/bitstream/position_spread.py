"""How far a vertex may be from a prediction: two spreads, in the plane of its surroundings and along their normal.

The error lies flat: it is several times smaller along the normal. With the covariance s^2 (I - k n n^T), k = 1 -
(normal spread / spread in the plane)^2, the coordinates are coded one after the other, each with the mean and the
spread that Student's distribution (four degrees of freedom) leaves it, given those before.

The logarithm of a spread is that of the neighbourhood's size plus a sum of twelve features with weights of their own,
by number of flaps; after each vertex the weights climb the slope of the likelihood. Logarithms are in 1/256 octave,
of 1/256 lattice step.
"""
from typing import NamedTuple

import numpy as np

from ..jit import njit
from .fixed_point import exp2, log2, log_length
from .position_guess import PREDICTORS
from .vertex_surroundings import (
    ALONG_NORMAL,
    COUNT,
    DIFFERENCE,
    DISAGREEMENT,
    EDGE,
    END_DEGREES,
    IN_PLANE,
    NEIGHBOURS,
)

FEATURES = 12
CLASSES = 4                 # no flap, one, two, more
LEAST, MOST = 4 << 8, 30 << 8   # logarithm of a spread: 1/16 and 2^22 lattice steps
_FLATTEST = 6 << 8          # the normal spread is not smaller by more octaves
_ONE = 1 << 20              # fixed point of the covariance
_TINY = 256                 # the least variance
_FREEDOM = 4                # of Student's distribution
_RATE = 4096                # of learning
_STEEP = 1 << 20            # no weight is larger


class Spread(NamedTuple):
    """Spreads of one vertex. All int64.

    weights (4, 2, 2, 12): by class, predictor, in the plane and along the normal, 16.16; features (12,); class_ (1,);
    logs (2, 2): spreads by predictor, in the plane and along the normal; excess (2,): sum of squares of the coordinates so
    far, each over its spread, times 256.
    """

    weights: np.ndarray
    features: np.ndarray
    class_: np.ndarray
    logs: np.ndarray
    excess: np.ndarray


def new_spread(weights: np.ndarray) -> Spread:
    """Room for spreads that begin with these weights (4, 2, 2, 12)."""
    return Spread(weights.copy(), np.zeros(FEATURES, np.int64), np.zeros(1, np.int64), np.zeros((PREDICTORS, 2), np.int64),
                  np.zeros(PREDICTORS, np.int64))


@njit(inline="always")
def _clip(x, middle, reach):
    return min(max(x - middle, -reach), reach)


@njit
def find_features(spread, guess, surface, room, v):
    """What the spreads depend on, each about 0 in the mean."""
    f, numbers, vectors, normal = spread.features, room.numbers, guess.vectors, guess.normal
    count, known, size = numbers[COUNT], numbers[NEIGHBOURS], guess.size[0]
    f[:] = 0
    spread.class_[0] = min(count, 3)
    if known > 0:
        f[0] = 256
    if count == 0:
        return
    own = min(max(surface.degree[v] - 6, -3), 3)
    f[1] = _clip(numbers[EDGE] // count + 2048 - size, 0, 512)
    f[2] = _clip(numbers[IN_PLANE] // known - size, -512, 768)
    f[3] = _clip(numbers[ALONG_NORMAL] // known - size, -768, 768)
    if count > 1:
        f[4] = _clip(numbers[DISAGREEMENT] + 2048 - size, -256, 768)
        apart = room.sums[DIFFERENCE, 0] * normal[0] + room.sums[DIFFERENCE, 1] * normal[1] + room.sums[DIFFERENCE, 2] * normal[2]
        f[5] = _clip(log2(abs(apart >> 6) + 64) - size, -768, 768)
    f[6] = _clip(log_length(vectors[1, 0], vectors[1, 1], vectors[1, 2]) - size, -512, 512)
    f[7] = abs(own) * 64
    f[8] = _clip(log_length(vectors[7, 0], vectors[7, 1], vectors[7, 2]) - size, -256, 512)
    f[9] = _clip(log_length(vectors[6, 0], vectors[6, 1], vectors[6, 2]) - size, -256, 512)
    f[10] = numbers[END_DEGREES] * 8 // count * 4
    f[11] = own * 64


@njit
def find_spreads(spread, guess):
    """The spreads of both predictors."""
    for p in range(PREDICTORS):
        for side in range(2):
            total = 0
            for f in range(FEATURES):
                total += spread.weights[spread.class_[0], p, side, f] * spread.features[f]
            spread.logs[p, side] = min(max(guess.size[0] + (total >> 16), LEAST), MOST - 256)
        spread.logs[p, 1] = min(max(spread.logs[p, 1], spread.logs[p, 0] - _FLATTEST), spread.logs[p, 0])
        spread.excess[p] = 0


@njit(inline="always")
def given_before(spread, guess, centre, at, v, p, axis):
    """Mean, into centre[p], and logarithm of the spread of predictor p on an axis, given the axes before it."""
    n0, n1, n2 = guess.normal[0], guess.normal[1], guess.normal[2]
    thin = exp2(2 * (spread.logs[p, 1] - spread.logs[p, 0])) << 4
    if n0 == 0 and n1 == 0 and n2 == 0:
        thin = _ONE
    k = _ONE - thin
    mean, log = guess.means[p, axis], spread.logs[p, 0]
    first = max(_ONE - (k * (n0 * n0 >> 8) >> 20), _TINY)
    if axis == 0:
        log += (log2(first) - 5120) >> 1
    elif axis == 1:
        across = -(k * (n0 * n1 >> 8) >> 20)
        mean += ((at[v, 0] << 8) - guess.means[p, 0]) * across // first
        log += (log2(max(_ONE - (k * (n1 * n1 >> 8) >> 20) - across * across // first, _TINY)) - 5120) >> 1
    else:
        whole = max(thin + (k * (n2 * n2 >> 8) >> 20), _TINY)
        off = (n0 * ((at[v, 0] << 8) - guess.means[p, 0]) + n1 * ((at[v, 1] << 8) - guess.means[p, 1])) >> 14
        mean -= (k * n2 >> 14) * min(max(off, -(1 << 33)), 1 << 33) // whole
        log += (log2(thin) - log2(whole)) >> 1
    if axis > 0:
        log += (log2((_FREEDOM << 8) + spread.excess[p]) - log2((_FREEDOM + axis) << 8)) >> 1
    centre[p] = min(max(mean, -(1 << 30)), 1 << 30)
    return min(max(log, LEAST), MOST)


@njit(inline="always")
def slope_of(error, log, dimensions):
    """Slope of the likelihood's logarithm over that of a spread, times 256; error: logarithm of what was measured."""
    square = exp2(min(max(2 * (error - log), -3072), 3072)) >> 8
    return ((_FREEDOM + dimensions) * square * 256 // ((_FREEDOM << 8) + square) - dimensions * 256) // dimensions


@njit(inline="always")
def climb(weights, features, slope, rate):
    """Move weights (f,) up the slope."""
    norm = 1 << 18
    for f in range(len(features)):
        norm += features[f] * features[f]
    step = (slope * rate << 8) // norm
    for f in range(len(features)):
        weights[f] = min(max(weights[f] + (step * features[f] >> 8), -_STEEP), _STEEP)


@njit
def learn_spreads(spread, guess, errors, at, v):
    """Compare vertex v with its predictions; the logarithms of the first's errors go to errors[v, 0] and errors[v, 1]."""
    n0, n1, n2 = guess.normal[0], guess.normal[1], guess.normal[2]
    for p in range(PREDICTORS):
        e0 = (at[v, 0] << 8) - guess.means[p, 0]
        e1 = (at[v, 1] << 8) - guess.means[p, 1]
        e2 = (at[v, 2] << 8) - guess.means[p, 2]
        along = (n0 * e0 + n1 * e1 + n2 * e2) >> 14
        e0, e1, e2 = e0 - (along * n0 >> 14), e1 - (along * n1 >> 14), e2 - (along * n2 >> 14)
        flat = log_length(e0, e1, e2) if max(abs(e0), abs(e1), abs(e2)) > 64 else 1536
        high = log2(abs(along) + 48)
        climb(spread.weights[spread.class_[0], p, 0], spread.features, slope_of(flat, spread.logs[p, 0], 2), _RATE)
        if n0 != 0 or n1 != 0 or n2 != 0:
            climb(spread.weights[spread.class_[0], p, 1], spread.features, slope_of(high, spread.logs[p, 1], 1), _RATE)
        if p == 0:
            errors[v, 0], errors[v, 1] = flat, high
