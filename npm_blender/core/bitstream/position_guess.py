"""Where a vertex is expected: two linear predictors that learn, and the frame in which their errors are measured.

A prediction is M + sum_j w_j b_j, M the mean middle of the flaps' edges (see `vertex_surroundings`) and b_j ten
vectors of the neighbourhood: from the mean apex to M; from M to the centre of the known neighbours; the same two
times the vertex's degree; the first times the degrees of the flaps' ends and of their apices; to the pivot, and what
would put the pivot into the centre of its neighbours; the normal parts of the first two. Rows of weights by kind: one
flap, two by the pivot's degree, more. After each vertex the weights take a step down the error's slope (normalised
least mean squares: Widrow and Hoff 1960), one predictor slowly, one faster. Vectors are in 1/256 of a lattice step.
"""
from typing import NamedTuple

import numpy as np

from ..jit import njit
from .fixed_point import log_length, square_root
from .vertex_surroundings import (
    APEX_DEGREES,
    APICES,
    CENTRE,
    COUNT,
    EDGE,
    END_DEGREES,
    ENDS,
    MISSING,
    NEIGHBOURS,
    NORMAL,
    PIVOT,
)

PREDICTORS = 2
VECTORS = 10
KINDS = 9                   # 0: no flap; 1: one; 2..7: two, pivot of degree up to 4, 5, .. 9 and more; 8: more flaps
_RATES = (2048, 8192)       # of learning, in 2^-16
_FAR = 1 << 33              # no vector is longer
_STEEP = 1 << 19            # no weight is larger


class Guess(NamedTuple):
    """Predictions of one vertex. All int64.

    weights (2, 9, 10): 16.16; vectors (10, 3); means (2, 3): predictions; normal (3,): unit, times 2^14, or 0;
    size (2,): 256 log2 of the neighbourhood's size in 1/256 steps, of this vertex and of the last that had flaps;
    kind (1,): see KINDS.
    """

    weights: np.ndarray
    vectors: np.ndarray
    means: np.ndarray
    normal: np.ndarray
    size: np.ndarray
    kind: np.ndarray


def new_guess(weights: np.ndarray) -> Guess:
    """Room for predictions that begin with these weights (2, 9, 10)."""
    size = np.full(2, 16 << 8, np.int64)
    vectors, means = np.zeros((VECTORS, 3), np.int64), np.zeros((PREDICTORS, 3), np.int64)
    return Guess(weights.copy(), vectors, means, np.zeros(3, np.int64), size, np.zeros(1, np.int64))


@njit(inline="always")
def _find_normal(guess, sums):
    """The mean normal of the flaps' faces."""
    x, y, z = sums[NORMAL, 0], sums[NORMAL, 1], sums[NORMAL, 2]
    size, shift = max(abs(x), abs(y), abs(z)), 0
    while size >> shift >= 1 << 24:
        shift += 1
    x, y, z = x >> shift, y >> shift, z >> shift
    length = max(square_root(x * x + y * y + z * z), 1)
    guess.normal[0], guess.normal[1], guess.normal[2] = (x << 14) // length, (y << 14) // length, (z << 14) // length


@njit(inline="always")
def _expect_without_flaps(guess, room, at, v):
    """The centre of the known neighbours, or else the vertex before."""
    known = room.numbers[NEIGHBOURS]
    for a in range(3):
        if known > 0:
            mean = (room.sums[CENTRE, a] << 8) // known
        else:
            mean = at[v - 1, a] << 8 if v > 0 else 0
        for p in range(PREDICTORS):
            guess.means[p, a] = mean
    guess.normal[:] = 0
    guess.kind[0] = 0
    guess.size[0] = guess.size[1]


@njit(inline="always")
def _find_vectors(guess, surface, memory, room, at, v):
    """The ten vectors, from the sums over the neighbourhood; the middle goes to the first row of `means`."""
    vectors, sums, numbers = guess.vectors, room.sums, room.numbers
    count, known, pivot = numbers[COUNT], numbers[NEIGHBOURS], numbers[PIVOT]
    own = min(max(surface.degree[v] - 6, -3), 3)
    ends, apices = numbers[END_DEGREES] * 8 // count, numbers[APEX_DEGREES] * 16 // count
    first, second = 0, 0
    for a in range(3):
        middle = (sums[ENDS, a] << 7) // count
        guess.means[0, a] = middle
        vectors[0, a] = middle - (sums[APICES, a] << 8) // count
        vectors[1, a] = (sums[CENTRE, a] << 8) // known - middle
        vectors[2, a] = vectors[0, a] * own >> 1
        vectors[3, a] = vectors[1, a] * own >> 1
        vectors[4, a] = vectors[0, a] * ends >> 5
        vectors[5, a] = vectors[0, a] * apices >> 5
        vectors[6, a], vectors[7, a] = 0, 0
        if pivot >= 0:
            vectors[6, a] = (at[pivot, a] << 8) - middle
            lean = ((at[pivot, a] * memory.known[pivot] - memory.total[pivot, a]) << 8) // max(numbers[MISSING], 1)
            vectors[7, a] = min(max(lean, -_FAR), _FAR)
        first += vectors[0, a] * guess.normal[a]
        second += vectors[1, a] * guess.normal[a]
    for a in range(3):
        vectors[8, a] = (first >> 14) * guess.normal[a] >> 14
        vectors[9, a] = (second >> 14) * guess.normal[a] >> 14


@njit
def expect(guess, surface, memory, room, at, v):
    """Predict vertex v from its surroundings."""
    numbers, vectors = room.numbers, guess.vectors
    count = numbers[COUNT]
    if count == 0:
        _expect_without_flaps(guess, room, at, v)
        return
    _find_normal(guess, room.sums)
    _find_vectors(guess, surface, memory, room, at, v)
    kind = 1
    if count == 2:
        kind = 2 if numbers[PIVOT] < 0 else 1 + min(max(surface.degree[numbers[PIVOT]] - 3, 1), 6)
    elif count > 2:
        kind = 8
    guess.kind[0] = kind
    for a in range(3):
        middle = guess.means[0, a]
        for p in range(PREDICTORS):
            total = 0
            for j in range(VECTORS):
                total += guess.weights[p, kind, j] * vectors[j, a]
            guess.means[p, a] = min(max(middle + (total >> 16), -(1 << 31)), 1 << 31)
    edge = numbers[EDGE] // count + 2048
    guess.size[0] = (log_length(vectors[0, 0], vectors[0, 1], vectors[0, 2]) + edge) >> 1
    guess.size[1] = guess.size[0]


@njit
def learn_to_guess(guess, at, v):
    """Move the weights towards what would have predicted vertex v better."""
    vectors, kind = guess.vectors, guess.kind[0]
    if kind == 0:
        return
    for p in range(PREDICTORS):
        e0 = (at[v, 0] << 8) - guess.means[p, 0]
        e1 = (at[v, 1] << 8) - guess.means[p, 1]
        e2 = (at[v, 2] << 8) - guess.means[p, 2]
        size, shift = max(abs(e0), abs(e1), abs(e2)), 0
        for j in range(VECTORS):
            size = max(size, abs(vectors[j, 0]), abs(vectors[j, 1]), abs(vectors[j, 2]))
        while size >> shift >= 1 << 20:
            shift += 1
        e0, e1, e2 = e0 >> shift, e1 >> shift, e2 >> shift
        norm = 2 * (e0 * e0 + e1 * e1 + e2 * e2) + 256
        for j in range(VECTORS):
            for a in range(3):
                norm += (vectors[j, a] >> shift) * (vectors[j, a] >> shift)
        for j in range(VECTORS):
            slope = e0 * (vectors[j, 0] >> shift) + e1 * (vectors[j, 1] >> shift) + e2 * (vectors[j, 2] >> shift)
            step = slope * _RATES[p] // norm
            guess.weights[p, kind, j] = min(max(guess.weights[p, kind, j] + step, -_STEEP), _STEEP)
