"""Steps from a half-edge to its neighbours in the same face, compiled; numbering as in `mesh.topology`: h = 3 f + k."""
from ..jit import compiled


@compiled(inline="always")
def next_halfedge(h):
    """The next half-edge in the face of h, an int: from corner k to corner k + 1 modulo 3.

    >>> from npm_blender.core.geometry import next_halfedge
    >>> [next_halfedge(h) for h in range(6)]
    [1, 2, 0, 4, 5, 3]
    """
    return h - 2 if h % 3 == 2 else h + 1


@compiled(inline="always")
def prev_halfedge(h):
    """The previous half-edge in the face of h, an int: the inverse of `next_halfedge`.

    >>> from npm_blender.core.geometry import prev_halfedge
    >>> [prev_halfedge(h) for h in range(6)]
    [2, 0, 1, 5, 3, 4]
    """
    return h + 2 if h % 3 == 0 else h - 1


@compiled
def end_of(flat, h):
    """The vertex at the end of half-edge h; flat (3 m,) int32: the faces in one row, the vertex at the start of each half-edge.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import end_of
    >>> flat = np.array([[7, 8, 9]], np.int32).reshape(-1)
    >>> [end_of(flat, h) for h in range(3)]
    [8, 9, 7]
    """
    return flat[h - 2] if h % 3 == 2 else flat[h + 1]
