"""How vertices move points: sparse matrices as rows, and then as columns of the unknowns."""
from typing import NamedTuple

import numpy as np

from ..jit import compiled


class Rows(NamedTuple):
    """A sparse matrix by rows. start (n + 1,) int64, column (k,) int32, weight (k,) float64; columns: how many there are."""

    start: np.ndarray
    column: np.ndarray
    weight: np.ndarray
    columns: int

    @staticmethod
    def identity(n: int) -> "Rows":
        """Ones on the diagonal."""
        return Rows(np.arange(n + 1), np.arange(n, dtype=np.int32), np.ones(n), n)

    def times(self, other: "Rows") -> "Rows":
        """The product of both."""
        start, column, weight = _product(self.start, self.column, self.weight, other.start, other.column, other.weight,
                                         other.columns)
        return Rows(start, column, weight, other.columns)

    def without(self, first: int) -> "Rows":
        """Its columns from `first` on."""
        start, column, weight = _tail(self.start, self.column, self.weight, first)
        return Rows(start, column, weight, self.columns - first)


class Columns(NamedTuple):
    """A sparse matrix by columns. start (columns + 1,) int64, row (k,) int32, weight (k,) float32."""

    start: np.ndarray
    row: np.ndarray
    weight: np.ndarray


@compiled(allocates=True)
def _product(a_start, a_index, a_weight, b_start, b_index, b_weight, columns):
    n, most = len(a_start) - 1, 0
    for p in range(len(a_index)):
        most += b_start[a_index[p] + 1] - b_start[a_index[p]]
    start, index, weight = np.zeros(n + 1, np.int64), np.empty(most, np.int32), np.empty(most)
    at, place = np.full(columns, -1, np.int64), 0
    for i in range(n):
        begun = place
        for p in range(a_start[i], a_start[i + 1]):
            row = a_index[p]
            for q in range(b_start[row], b_start[row + 1]):
                value = a_weight[p] * b_weight[q]
                if value == 0:
                    continue
                j = b_index[q]
                if at[j] < begun:
                    at[j] = place
                    index[place], weight[place] = j, 0.0
                    place += 1
                weight[at[j]] += value
        start[i + 1] = place
    return start, index[:place].copy(), weight[:place].copy()


@compiled(allocates=True)
def _tail(start, index, weight, first):
    out, place = np.zeros(len(start), np.int64), 0
    kept, value = np.empty(len(index), np.int32), np.empty(len(index))
    for i in range(len(start) - 1):
        for p in range(start[i], start[i + 1]):
            if index[p] >= first:
                kept[place], value[place] = index[p] - first, weight[p]
                place += 1
        out[i + 1] = place
    return out, kept[:place].copy(), value[:place].copy()


def columns_of(rows: Rows, corner: np.ndarray, share: np.ndarray) -> Columns:
    """How each column moves points that are sums of three rows: corner (k, 3) int32 rows, share (k, 3) weights."""
    return Columns(*_columns(rows.start, rows.column, rows.weight, rows.columns, corner, share))


@compiled(allocates=True)
def _columns(start, index, weight, columns, corner, share):
    first, mark = np.zeros(columns + 1, np.int64), np.full(columns, -1, np.int64)
    for k in range(len(corner)):
        for c in range(3):
            if share[k, c] != 0:
                for p in range(start[corner[k, c]], start[corner[k, c] + 1]):
                    if mark[index[p]] != k:
                        mark[index[p]] = k
                        first[index[p] + 1] += 1
    first = np.cumsum(first)
    mark[:] = -1
    end = first[:-1].copy()
    row, value = np.empty(first[-1], np.int32), np.zeros(first[-1], np.float32)
    for k in range(len(corner)):
        for c in range(3):
            if share[k, c] != 0:
                for p in range(start[corner[k, c]], start[corner[k, c] + 1]):
                    j = index[p]
                    if mark[j] != k:
                        mark[j] = k
                        row[end[j]] = k
                        end[j] += 1
                    value[end[j] - 1] += share[k, c] * weight[p]
    return first, row, value
