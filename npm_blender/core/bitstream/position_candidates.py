"""Places where a vertex may be exactly: each flap's parallelogram, the two predictions, known neighbours.

Where a surface is made of planes or of regular rows one of them is right to a lattice step and their mean is wrong.
So they form a mixture: shares that say how much each is trusted, and one spread for all. The shares begin at what
served vertices with as many flaps, and after each coordinate move to the candidates that came near it (Bayes' rule),
so the first coordinate tells which candidate the others follow. Positions in 1/256 of a lattice step, logarithms in
1/256 octave.
"""
from typing import NamedTuple

import numpy as np

from ..jit import njit
from .fixed_point import ONE_TAIL, exp2, log2, tail
from .position_guess import PREDICTORS
from .position_spread import LEAST, MOST, climb, slope_of
from .vertex_surroundings import LEAST as LEAST_ERROR
from .vertex_surroundings import NEAREST, NEIGHBOURS

MOST_CANDIDATES = 8         # three flaps, two predictions, three neighbours
FEATURES = 5
WHOLE = 1 << 16             # all shares together
_SLIGHT = 512               # a share below this is none
_DOUBT = 3000               # added to each share before a coordinate counts
_RATE = 2048                # of learning


class Candidates(NamedTuple):
    """Candidates of one vertex. All int64.

    places (3, 8): by axis; shares (8,); served (4, 8): shares that served so far, by class; chances (8,): room;
    weights (4, 5), features (5,): of the spread's logarithm; numbers (3,): candidates, logarithm of the spread, and 2^32 over
    the spread.
    """

    places: np.ndarray
    shares: np.ndarray
    served: np.ndarray
    chances: np.ndarray
    weights: np.ndarray
    features: np.ndarray
    numbers: np.ndarray


def new_candidates(served: np.ndarray, weights: np.ndarray) -> Candidates:
    """Room for candidates that begin with these shares (4, 8) and weights (4, 5)."""
    shares, chances = np.zeros((2, MOST_CANDIDATES), np.int64)
    return Candidates(np.zeros((3, MOST_CANDIDATES), np.int64), shares, served.copy(), chances, weights.copy(),
                      np.zeros(FEATURES, np.int64), np.zeros(3, np.int64))


@njit
def list_candidates(candidates, guess, spread, room):
    """The candidates of a vertex, their shares and their spread."""
    places, shares, numbers = candidates.places, candidates.shares, candidates.numbers
    class_, known = spread.class_[0], room.numbers[NEIGHBOURS]
    copies = 0 if class_ == 0 else (2 if class_ == 1 else 3)
    for a in range(3):
        for j in range(class_):
            places[a, j] = room.flaps[j, a] << 8
        for p in range(PREDICTORS):
            places[a, class_ + p] = guess.means[p, a]
        for j in range(copies):
            places[a, class_ + PREDICTORS + j] = room.copies[j, a] << 8
    count = class_ + PREDICTORS + copies
    total = 1
    for j in range(count):
        total += candidates.served[class_, j]
    for j in range(count):
        shares[j] = candidates.served[class_, j] * WHOLE // total
    f, size = candidates.features, guess.size[0]
    f[:] = 0
    f[0] = 256
    if class_ > 0:
        f[1] = min(max(room.numbers[NEAREST] // known - size + 768, -1024), 1024)
        f[2] = min(max(room.numbers[LEAST_ERROR] - size + 768, -1024), 1024)
        f[3], f[4] = spread.features[4], spread.features[1]
    log = 0
    for i in range(FEATURES):
        log += candidates.weights[class_, i] * f[i]
    numbers[0] = count
    numbers[1] = min(max(size + (log >> 16), LEAST), MOST - 256)
    numbers[2] = (1 << 48) // exp2(numbers[1])


@njit(inline="always")
def below(distance, inverse):
    """Chance, of 2^30, of lying below a place so far above the centre; inverse: 2^32 over the spread."""
    chance = tail(min(abs(distance), 1 << 30) * inverse >> 19)
    return chance if distance < 0 else ONE_TAIL - chance


@njit(inline="always")
def weigh(candidates, axis, value):
    """Move the shares to the candidates that came near the value."""
    shares, chances, count, inverse = candidates.shares, candidates.chances, candidates.numbers[0], candidates.numbers[2]
    total = 1
    for j in range(count):
        d = (value << 8) - candidates.places[axis, j]
        mass = max(below(d + 128, inverse) - below(d - 128, inverse), 0) + 64
        chances[j] = (shares[j] + _DOUBT) * mass >> 16
        total += chances[j]
    left = 1
    for j in range(count):
        shares[j] = chances[j] * WHOLE // total
        if shares[j] < _SLIGHT:
            shares[j] = 0
        left += shares[j]
    for j in range(count):
        shares[j] = shares[j] * WHOLE // left


@njit(inline="always")
def most_likely(candidates):
    """The candidate of the largest share."""
    best = 0
    for j in range(candidates.numbers[0]):
        if candidates.shares[j] > candidates.shares[best]:
            best = j
    return best


@njit
def learn_candidates(candidates, class_, errors, at, v):
    """Keep what served vertex v; the logarithm of what the nearest candidate was off by goes to errors[v, 2]."""
    nearest = 1 << 40
    for j in range(candidates.numbers[0]):
        candidates.served[class_, j] += (candidates.shares[j] - candidates.served[class_, j]) >> 4
        off = 0
        for a in range(3):
            off = max(off, abs((at[v, a] << 8) - candidates.places[a, j]))
        nearest = min(nearest, off)
    errors[v, 2] = log2(nearest + 48)
    climb(candidates.weights[class_], candidates.features, slope_of(errors[v, 2], candidates.numbers[1], 1), _RATE)
