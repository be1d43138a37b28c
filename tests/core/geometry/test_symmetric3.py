import numpy as np

from npm_blender.core.geometry.symmetric3 import DIAGONAL, add_outer, invert_blocks

FULL = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])  # where the six numbers stand in the matrix


def test_outer_products_add_up_and_the_diagonal_is_where_it_is_said_to_be():
    random = np.random.default_rng(0)
    vectors, weights, block = random.normal(size=(5, 3)), random.normal(size=5), np.zeros(6)
    for (x, y, z), w in zip(vectors, weights, strict=True):
        add_outer(block, x, y, z, w)
    assert np.allclose(block[FULL], np.einsum("k,ki,kj->ij", weights, vectors, vectors))
    assert np.array_equal(block[list(DIAGONAL)], block[FULL].diagonal())


def test_inverses_of_some_blocks():
    random = np.random.default_rng(1)
    blocks, out, rows = random.normal(size=(8, 6)), np.full((8, 6), 7.0), np.array([6, 0, 3])
    invert_blocks(blocks, rows, out)
    assert np.allclose(blocks[rows][:, FULL] @ out[rows][:, FULL], np.eye(3))
    assert (np.delete(out, rows, 0) == 7).all()
    invert_blocks(np.zeros((1, 6)), np.array([0]), out)
    assert not np.isfinite(out[0]).any()
