"""Integers that make a quadratic function plus the price of their bits small: coordinate descent, one by one."""

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_matrix

from npm_blender.core.jit import compiled

from .rates import bits_of, class_of


class Quadratic(NamedTuple):
    """x A x / 2 - rhs x, a function of the changes x of k integers.

    start, index, data: rows of A (CSR), float64; diagonal (k,): A's; rhs (k,): minus the gradient where the integers are
    now: it follows them.
    """

    start: np.ndarray
    index: np.ndarray
    data: np.ndarray
    diagonal: np.ndarray
    rhs: np.ndarray

    @staticmethod
    def of(A: csr_matrix, rhs: np.ndarray) -> "Quadratic":
        """From the matrix."""
        return Quadratic(A.indptr, A.indices, A.data, A.diagonal(), rhs)


class Integers(NamedTuple):
    """value (n,) int64: of all vertices; old (n,): what changes are counted from; near (n, 8): symbols.neighbours."""

    value: np.ndarray
    old: np.ndarray
    near: np.ndarray


class Price(NamedTuple):
    """Of the values of one level, in squared distance: bits, see Rate, times per_bit.

    fresh (classes, values), again (values,): as in Rate.
    """

    fresh: np.ndarray
    again: np.ndarray
    per_bit: float


@compiled
def _best_change(h, g, now, before, row, per_bit):
    """The change of an integer, 0 if none is better, with the least h x^2 / 2 - g x + price; row: bits by value.

    Tried are the two integers at the minimum without a price, the old value, and a step from the lower of the two towards
    the old value.
    """
    best, best_cost = 0, per_bit * bits_of(row, now - before)
    low = int(np.floor(g / h))
    for trial in range(4):
        if trial == 0:
            step = low
        elif trial == 1:
            step = low + 1
        elif trial == 2:
            step = before - now
        else:
            step = low + (1 if low + now < before else -1)
        if step == 0:
            continue
        cost = step * (0.5 * h * step - g) + per_bit * bits_of(row, now + step - before)
        if cost < best_cost:
            best, best_cost = step, cost
    return best


@compiled
def descend(model, integers, first, price, sweeps):
    """Coordinate descent over the integers value[first:], of which `model` tells the squared distance."""
    value, old, g = integers.value, integers.old, model.rhs
    for _ in range(sweeps):
        changed = 0
        for i in range(len(model.diagonal)):
            v = first + i
            if model.diagonal[i] <= 0:
                continue
            row = price.again if old[v] != 0 else price.fresh[class_of(value, integers.near, v)]
            change = _best_change(model.diagonal[i], g[i], value[v], old[v], row, price.per_bit)
            if change != 0:
                changed += 1
                value[v] += change
                for p in range(model.start[i], model.start[i + 1]):
                    g[model.index[p]] -= model.data[p] * change
        if changed == 0:
            break
