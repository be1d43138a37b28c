"""Bits that integers cost, measured from a sender's own: what the fit pays for them before they are coded."""
from typing import NamedTuple

import numpy as np

from ..jit import compiled

VALUES = 6  # length of a rate table: 0..5, then two bits more per doubling
CLASSES = 4  # of sizes of what is around
_DEFAULT = np.log2(1 / np.array([0.5, 0.3, 0.1, 0.05, 0.03, 0.02])) + np.array([0, 1, 1, 1, 1, 1.0])


class Rate(NamedTuple):
    """Bits: fresh (levels + 1, classes, values) for a vertex whose old value is 0, by the size of what is around it;
    again (values,) for a change of another."""

    fresh: np.ndarray
    again: np.ndarray


def default_rate(levels: int) -> Rate:
    """Bits before anything is known of a surface of so many levels; float64.

    >>> from npm_blender.core.fitting import default_rate
    >>> rate = default_rate(levels=2)
    >>> rate.fresh.shape, rate.again[:2].round(1).tolist()  # bits of a change by 0, by 1
    ((3, 4, 6), [1.0, 2.7])
    """
    return Rate(np.tile(_DEFAULT, (levels + 1, CLASSES, 1)), _DEFAULT.copy())


@compiled
def class_of(value, near, v):
    """Class (0..CLASSES - 1) of vertex v by the size of the integers around it."""
    around = 0
    for t in range(6):
        if near[v, t] >= 0:
            around += min(abs(value[near[v, t]]), 3)
    return 0 if around == 0 else (1 if around < 3 else (2 if around < 6 else 3))


@compiled
def bits_of(table, x):
    """Bits of an integer by a table for 0..VALUES - 1; every doubling beyond costs two bits more."""
    x = abs(x)
    if x < len(table):
        return table[x]
    return table[len(table) - 1] + 2 * np.log2(x / (len(table) - 1))


@compiled
def _count(value, old, near, first, fresh, again):
    """Counts of the values of each level and class into fresh and again."""
    largest = fresh.shape[2] - 1
    for level in range(len(first) - 1):
        for v in range(first[level], first[level + 1]):
            x = min(abs(value[v] - old[v]), largest)
            if old[v] != 0:
                again[x] += 1
            else:
                fresh[level, class_of(value, near, v), x] += 1


def measured_rate(value: np.ndarray, old: np.ndarray, near: np.ndarray, first: np.ndarray) -> Rate:
    """Bits by what the values are."""
    prior = 2.0 ** -default_rate(len(first) - 2).fresh[0, 0] * 8
    fresh = np.tile(prior, (len(first) - 1, CLASSES, 1))
    again = prior.copy()
    _count(value, old, near, first, fresh, again)
    sign = np.array([0, 1, 1, 1, 1, 1.0])
    return Rate(np.log2(fresh.sum(2, keepdims=True) / fresh) + sign, np.log2(again.sum() / again) + sign)
