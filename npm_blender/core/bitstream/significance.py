"""Which faces the features of a packet sit on.

Features come in groups: group g < L holds the latents of the faces of level g, group L + i the offsets of the faces of
level i, group 2 L + i what a second pass adds to them, and so on. Per group a packet tells for each face not yet sent
whether it is sent now; the chance of that is shared out by weights that follow what the faces around it did (parent
sent, neighbours sent), learned from packet to packet.

Near to the significance passes of embedded image coders (Shapiro 1993; Said and Pearlman 1996), and of their versions for
subdivided meshes (Khodakovsky, Schroeder and Sweldens 2000): there trees of zeros say which coefficients stay insignificant,
here the parents and neighbours of a face set its probability. The classes and their weights are ours.
"""
from typing import NamedTuple

import numpy as np

from ..jit import njit
from ..mesh import opposite_halfedges, subdivided_opposite
from .range_coder import ENCODE, MODE, ONE, code_probability

CLASSES = 16                    # of latents, as many of the offsets of each pass: see `_class_of`
_ONE_WEIGHT = 1 << 8
_MAX_WEIGHT = 1 << 14
_PRIOR = 4 << 8                 # the learned weights start as if this many (8 fractional bits) had behaved as expected


class Faces(NamedTuple):
    """Faces of all groups, numbered one group after the other.

    first (G + 1,) int64: first face of each group; twin (3 * total,) int32: opposite half-edges in the same group,
    itself on the border; levels: L, the number of groups of latents.
    """

    first: np.ndarray
    twin: np.ndarray
    levels: int


class Sent(NamedTuple):
    """What both sides know and have learned about faces. row (total,) int32: 1 + index of the feature of a face, 0
    unsent; weights (G / L * CLASSES,); count (G,): sent of each group; last (G + 1,): counts of the batch before, and its
    size; hits, expected, as weights: of each class, how many were sent in the batch and how many were to be expected."""

    row: np.ndarray
    weights: np.ndarray
    count: np.ndarray  # type: ignore[assignment]  # a field, which hides tuple.count
    last: np.ndarray
    hits: np.ndarray
    expected: np.ndarray


def faces_of(F0: np.ndarray, levels: int, passes: int = 0) -> Faces:
    """The faces of `levels` groups of latents, and of as many of offsets in each pass, over the base faces F0 (m0, 3)."""
    opposite = opposite_halfedges(F0).astype(np.int64)
    first, tables = [0], []
    for i in range(levels):
        tables.append((3 * first[-1] + opposite).astype(np.int32))
        first.append(first[-1] + len(opposite) // 3)
        if i + 1 < levels:
            opposite = subdivided_opposite(opposite)
    total, one, ends = first[-1], np.concatenate(tables), first[1:]
    for p in range(1, passes + 1):
        first += [p * total + f for f in ends]
        tables.append(one + 3 * p * total)
    return Faces(np.array(first, dtype=np.int64), np.concatenate(tables), levels)


def nothing_sent(faces: Faces) -> Sent:
    """The state before the first packet."""
    groups = len(faces.first) - 1
    last = np.ones(groups + 1, np.int64)
    last[groups] = groups
    weights = np.full(groups // faces.levels * CLASSES, _ONE_WEIGHT, np.int64)
    return Sent(np.zeros(faces.first[-1], np.int32), weights, np.zeros(groups, np.int64), last, np.zeros_like(weights),
                np.zeros_like(weights))


@njit
def parent_row(faces, sent, group, g):
    """Row of the feature of the parent of face g in the group of the level above, -1 if there is none or it is unsent."""
    if group % faces.levels == 0:
        return -1
    return sent.row[faces.first[group - 1] + (g - faces.first[group]) // 4] - 1


@njit
def _class_of(faces, sent, group, g):
    """Class of an unsent face g of a group by what was sent around it."""
    around = 0
    for t in range(3):
        around += sent.row[faces.twin[3 * g + t] // 3] > 0
    base = group // faces.levels * CLASSES
    if group % faces.levels == 0:
        return base + around
    return base + CLASSES // 2 + 4 * (parent_row(faces, sent, group, g) >= 0) + around


@njit
def _unsent(faces, sent, group):
    """How many faces of a group are unsent, and the sum of the weights of their classes."""
    rest, total = 0, 0
    for g in range(faces.first[group], faces.first[group + 1]):
        if sent.row[g] == 0:
            total += sent.weights[_class_of(faces, sent, group, g)]
            rest += 1
    return rest, total


@njit
def _weights_to_come(faces, sent, group, g):
    """Sum of the weights of the classes of the unsent faces beside g that come after it."""
    total = 0
    for t in range(3):
        o = faces.twin[3 * g + t] // 3
        if o > g and sent.row[o] == 0:
            total += sent.weights[_class_of(faces, sent, group, o)]
    return total


@njit
def code_faces(coder, faces, sent, face, group, at, count):
    """Which `count` of the unsent faces of a group are sent now, face[at:at + count] ascending.

    A face of class c is sent with the probability count * w_c / (sum of the weights of the unsent faces from it on); after the
    packet, w_c is scaled by (hits_c + 4) / (expected_c + 4).
    """
    sending = coder.rc[MODE] == ENCODE
    first, stop = faces.first[group], faces.first[group + 1]
    rest, total = _unsent(faces, sent, group)
    hits, expected = sent.hits, sent.expected
    for c in range(len(hits)):
        hits[c], expected[c] = 0, 0
    for g in range(first, stop):
        if count == 0:
            break
        if sent.row[g] > 0:
            continue
        kind = _class_of(faces, sent, group, g)
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
            before = _weights_to_come(faces, sent, group, g)
            face[at] = g - first
            at += 1
            count -= 1
            sent.row[g] = at
            total += _weights_to_come(faces, sent, group, g) - before
    for c in range(len(hits)):
        weight = sent.weights[c] * (hits[c] + _PRIOR) // (expected[c] + _PRIOR)
        sent.weights[c] = min(max(weight, 4), _MAX_WEIGHT)
