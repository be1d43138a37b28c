"""Sparse matrices do what dense ones do."""
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from npm_blender.core.fitting.influence import Rows, columns_of


def dense(rows):
    out = np.zeros((len(rows.start) - 1, rows.columns))
    for i in range(len(out)):
        for p in range(rows.start[i], rows.start[i + 1]):
            out[i, rows.column[p]] += rows.weight[p]
    return out


def sparse(A):
    i, j = np.nonzero(A)
    return Rows(np.concatenate([[0], np.cumsum((A != 0).sum(1))]).astype(np.int64), j.astype(np.int32), A[i, j], A.shape[1])


def some(rng, n, m):
    return np.round(rng.normal(size=(n, m)), 3) * (rng.random((n, m)) < 0.4)


@given(st.integers(0, 2**31), st.integers(1, 6), st.integers(1, 6), st.integers(1, 6))
def test_products_and_tails(seed, n, m, k):
    rng = np.random.default_rng(seed)
    A, B = some(rng, n, m), some(rng, m, k)
    assert np.allclose(dense(sparse(A).times(sparse(B))), A @ B)
    assert np.array_equal(dense(sparse(A).without(m // 2)), A[:, m // 2:])
    assert np.array_equal(dense(Rows.identity(m).times(sparse(B))), B)


@given(st.integers(0, 2**31))
def test_columns_of_points_that_are_means_of_rows(seed):
    rng = np.random.default_rng(seed)
    A, corner = some(rng, 8, 5), rng.integers(0, 8, (20, 3)).astype(np.int32)
    share = rng.random((20, 3)) * (rng.random((20, 3)) < 0.8)
    found, expected = columns_of(sparse(A), corner, share), np.einsum("kc,kcj->kj", share, A[corner])
    for j in range(5):
        column = np.zeros(20)
        np.add.at(column, found.row[found.start[j]:found.start[j + 1]], found.weight[found.start[j]:found.start[j + 1]])
        assert np.allclose(column, expected[:, j], atol=1e-6)
