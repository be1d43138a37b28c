"""The solver against a dense one."""
import numpy as np
import pytest

from npm_blender.core.levels.block_cg import TOLERANCE, BlockMatrix, conjugate_gradients

FULL = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])  # where the six numbers stand in a block


@pytest.fixture
def system():
    """A positive definite matrix, the same as one dense array, and a right-hand side."""
    random, n = np.random.default_rng(0), 12
    edges = np.array([(i, j) for i in range(n) for j in range(i + 1, n) if random.random() < 0.3], np.int32)
    matrix = BlockMatrix(random.normal(size=(n, 6)), random.normal(size=(len(edges), 6)), edges)
    matrix.diagonal[:, [0, 3, 5]] += 20
    dense = np.zeros((n, 3, n, 3))
    dense[np.arange(n), :, np.arange(n)] = matrix.diagonal[:, FULL]
    for (i, j), block in zip(edges, matrix.off_diagonal[:, FULL], strict=True):
        dense[i, :, j] = dense[j, :, i] = block
    dense = dense.reshape(3 * n, 3 * n)
    assert np.linalg.eigvalsh(dense).min() > 0
    return matrix, dense, random.normal(size=(n, 3))


def test_the_solution_is_that_of_a_dense_solver(system):
    matrix, dense, rhs = system
    x = np.zeros_like(rhs)
    conjugate_gradients(matrix, rhs, np.arange(len(rhs)), np.arange(len(matrix.edges)), x, 1e-20)
    assert np.allclose(x.reshape(-1), np.linalg.solve(dense, rhs.reshape(-1)), atol=1e-8)


def test_some_vertices_are_solved_for_while_the_others_stay(system):
    matrix, dense, rhs = system
    free, start = np.array([1, 4, 5, 9]), np.random.default_rng(1).normal(size=rhs.shape)
    x, at = start.copy(), np.flatnonzero(np.isin(matrix.edges, free).any(1))
    conjugate_gradients(matrix, rhs, free, at, x, 1e-20)
    stay = np.setdiff1d(np.arange(len(rhs)), free)
    assert np.array_equal(x[stay], start[stay])
    residual = (rhs.reshape(-1) - dense @ x.reshape(-1)).reshape(-1, 3)
    assert np.abs(residual[free]).max() < 1e-8


def test_it_stops_at_the_residual_asked_for(system):
    matrix, dense, rhs = system
    inverse = np.linalg.inv(matrix.diagonal[:, FULL])
    first = np.einsum("ni,nij,nj", rhs, inverse, rhs)
    x = np.zeros_like(rhs)
    least = conjugate_gradients(matrix, rhs, np.arange(len(rhs)), np.arange(len(matrix.edges)), x, -1.0)
    residual = (rhs.reshape(-1) - dense @ x.reshape(-1)).reshape(-1, 3)
    assert least == pytest.approx(TOLERANCE**2 * first)
    assert np.einsum("ni,nij,nj", residual, inverse, residual) <= 1.001 * least
