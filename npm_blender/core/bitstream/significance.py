"""Which faces the features of a batch sit on.

Per level a batch tells for each face not yet sent whether it is sent now; the chance of that is shared out by weights that
follow what the faces around it did (parent sent, neighbours sent), learned from batch to batch.

Near to the significance passes of embedded image coders (Shapiro 1993; Said and Pearlman 1996), and of their versions for
subdivided meshes (Khodakovsky, Schroeder and Sweldens 2000): there trees of zeros say which coefficients stay insignificant,
here the parents and neighbours of a face set its probability. The classes and their weights are ours.
"""
from typing import NamedTuple

import numpy as np

from ..jit import njit
from ..mesh import opposite_halfedges, subdivided_opposite
from .range_coder import ENCODE, MODE, ONE, code_probability

CLASSES = 16                    # see `_class_of`
_ONE_WEIGHT = 1 << 8
_MAX_WEIGHT = 1 << 14
_PRIOR = 4 << 8                 # the learned weights start as if this many (8 fractional bits) had behaved as expected


class Faces(NamedTuple):
    """Faces of levels 0..L - 1, numbered one level after the other.

    first (L + 1,) int64: first face of each level; twin (3 * total,) int32: opposite half-edges of the same level, itself on
    the border.
    """

    first: np.ndarray
    twin: np.ndarray


class Sent(NamedTuple):
    """What both sides know and have learned about faces. row (total,) int32: 1 + index of the feature of a face, 0
    unsent; weights (CLASSES,); count (L,): sent of each level; last (L + 1,): counts of the batch before, and its size;
    hits, expected, as weights: of each class, how many were sent in the batch and how many were to be expected."""

    row: np.ndarray
    weights: np.ndarray
    count: np.ndarray  # type: ignore[assignment]  # a field, which hides tuple.count
    last: np.ndarray
    hits: np.ndarray
    expected: np.ndarray


def faces_of(F0: np.ndarray, levels: int) -> Faces:
    """The faces of levels 0..levels - 1 over the base faces F0 (m0, 3)."""
    opposite = opposite_halfedges(F0).astype(np.int64)
    first, tables = [0], []
    for i in range(levels):
        tables.append((3 * first[-1] + opposite).astype(np.int32))
        first.append(first[-1] + len(opposite) // 3)
        if i + 1 < levels:
            opposite = subdivided_opposite(opposite)
    return Faces(np.array(first, dtype=np.int64), np.concatenate(tables))


def nothing_sent(faces: Faces) -> Sent:
    """The state before the first packet."""
    levels = len(faces.first) - 1
    last = np.ones(levels + 1, np.int64)
    last[levels] = levels
    weights = np.full(CLASSES, _ONE_WEIGHT, np.int64)
    return Sent(np.zeros(faces.first[-1], np.int32), weights, np.zeros(levels, np.int64), last, np.zeros_like(weights),
                np.zeros_like(weights))


@njit
def parent_row(faces, sent, level, g):
    """Row of the feature of the parent of face g in the level above, -1 if there is none or it is unsent."""
    if level == 0:
        return -1
    return sent.row[faces.first[level - 1] + (g - faces.first[level]) // 4] - 1


@njit
def _class_of(faces, sent, level, g):
    """Class of an unsent face g of a level by what was sent around it."""
    around = 0
    for t in range(3):
        around += sent.row[faces.twin[3 * g + t] // 3] > 0
    if level == 0:
        return around
    return CLASSES // 2 + 4 * (parent_row(faces, sent, level, g) >= 0) + around


@njit
def _unsent(faces, sent, level):
    """How many faces of a level are unsent, and the sum of the weights of their classes."""
    rest, total = 0, 0
    for g in range(faces.first[level], faces.first[level + 1]):
        if sent.row[g] == 0:
            total += sent.weights[_class_of(faces, sent, level, g)]
            rest += 1
    return rest, total


@njit
def _weights_to_come(faces, sent, level, g):
    """Sum of the weights of the classes of the unsent faces beside g that come after it."""
    total = 0
    for t in range(3):
        o = faces.twin[3 * g + t] // 3
        if o > g and sent.row[o] == 0:
            total += sent.weights[_class_of(faces, sent, level, o)]
    return total


@njit
def code_faces(coder, faces, sent, face, level, at, count):
    """Which `count` of the unsent faces of a level are sent now, face[at:at + count] ascending.

    A face of class c is sent with the probability count * w_c / (sum of the weights of the unsent faces from it on); after the
    packet, w_c is scaled by (hits_c + 4) / (expected_c + 4).
    """
    sending = coder.rc[MODE] == ENCODE
    first, stop = faces.first[level], faces.first[level + 1]
    rest, total = _unsent(faces, sent, level)
    hits, expected = sent.hits, sent.expected
    for c in range(len(hits)):
        hits[c], expected[c] = 0, 0
    for g in range(first, stop):
        if count == 0:
            break
        if sent.row[g] > 0:
            continue
        kind = _class_of(faces, sent, level, g)
        weight = sent.weights[kind]
        p = min(max((count * weight << 22) // max(total, 1), 1), ONE - (ONE >> 6))
        now = 1
        if count < rest:
            now = 1 if sending and face[at] == g - first else 0
            now = code_probability(coder, now, p)
            expected[kind] += p >> 14
            hits[kind] += now << 8
        total -= weight
        rest -= 1
        if now:
            before = _weights_to_come(faces, sent, level, g)
            face[at] = g - first
            at += 1
            count -= 1
            sent.row[g] = at
            total += _weights_to_come(faces, sent, level, g) - before
    for c in range(len(hits)):
        weight = sent.weights[c] * (hits[c] + _PRIOR) // (expected[c] + _PRIOR)
        sent.weights[c] = min(max(weight, 4), _MAX_WEIGHT)
