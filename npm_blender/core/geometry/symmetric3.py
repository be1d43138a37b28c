"""Symmetric 3 x 3 matrices as six numbers (xx, xy, xz, yy, yz, zz), compiled."""
from ..jit import compiled

DIAGONAL = (0, 3, 5)  # places of xx, yy and zz


@compiled
def add_outer(block, x, y, z, w):
    """Add w u u^T, for the vector u = (x, y, z), to a symmetric matrix, block (6,) float64, in place.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import DIAGONAL, add_outer
    >>> block = np.zeros(6)
    >>> add_outer(block, 1.0, 2.0, 3.0, 10.0)
    >>> block.tolist(), block[list(DIAGONAL)].tolist()
    ([10.0, 20.0, 30.0, 40.0, 60.0, 90.0], [10.0, 40.0, 90.0])
    """
    block[0] += w * x * x
    block[1] += w * x * y
    block[2] += w * x * z
    block[3] += w * y * y
    block[4] += w * y * z
    block[5] += w * z * z


@compiled
def invert_blocks(blocks, rows, out):
    """Set the rows (k,) of out (n, 6) float64 to the inverses of those of blocks (n, 6), by Cramer's rule: adj(A) / det(A).

    Not finite where a block is singular.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import invert_blocks
    >>> out = np.zeros((2, 6))
    >>> invert_blocks(np.array([[2.0, 0, 0, 4, 0, 8], [1, 0, 0, 1, 0, 1]]), np.array([0]), out)
    >>> out.tolist()
    [[0.5, 0.0, 0.0, 0.25, 0.0, 0.125], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]]
    """
    for v in rows:
        a, b, c, d, e, f = blocks[v, 0], blocks[v, 1], blocks[v, 2], blocks[v, 3], blocks[v, 4], blocks[v, 5]
        c00, c01, c02 = d * f - e * e, c * e - b * f, b * e - c * d
        s = 1.0 / (a * c00 + b * c01 + c * c02)
        out[v, 0], out[v, 1], out[v, 2] = s * c00, s * c01, s * c02
        out[v, 3], out[v, 4], out[v, 5] = s * (a * f - c * c), s * (b * c - a * e), s * (a * d - b * b)
