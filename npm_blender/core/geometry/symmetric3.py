"""Symmetric 3 x 3 matrices as six numbers (xx, xy, xz, yy, yz, zz), compiled."""
from ..jit import compiled

DIAGONAL = (0, 3, 5)  # of a block


@compiled
def add_outer(block, x, y, z, w):
    """Add w times the outer product of (x, y, z) with itself to a symmetric matrix (xx, xy, xz, yy, yz, zz)."""
    block[0] += w * x * x
    block[1] += w * x * y
    block[2] += w * x * z
    block[3] += w * y * y
    block[4] += w * y * z
    block[5] += w * z * z


@compiled
def invert_blocks(own, vertices, out):
    """out = own^-1, for symmetric 3 x 3 blocks (n, 6), at the vertices (k,)."""
    for v in vertices:
        a, b, c, d, e, f = own[v, 0], own[v, 1], own[v, 2], own[v, 3], own[v, 4], own[v, 5]
        c00, c01, c02 = d * f - e * e, c * e - b * f, b * e - c * d
        s = 1.0 / (a * c00 + b * c01 + c * c02)
        out[v, 0], out[v, 1], out[v, 2] = s * c00, s * c01, s * c02
        out[v, 3], out[v, 4], out[v, 5] = s * (a * f - c * c), s * (b * c - a * e), s * (a * d - b * b)
