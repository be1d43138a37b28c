"""Disjoint sets (union-find), compiled: the members 0..n - 1 of a forest, as an array of parents; a root is its own parent.

The root of a set is its smallest member, whichever way it was joined. Paths to the root are halved on the way (van Leeuwen and
van der Weide 1977; Tarjan and van Leeuwen 1984), so a step takes O(log n) on average.
"""
from ..jit import compiled


@compiled
def find_root(parent, i):
    """Root of member i, an int; halves the path to it in parent (n,), int32 or int64: every second member on it gets its
    grandparent as parent.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import find_root
    >>> parent = np.array([0, 0, 1, 2], np.int32)
    >>> find_root(parent, 3), parent.tolist()
    (0, [0, 0, 1, 1])
    """
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@compiled
def unite(parent, i, j):
    """Join the sets of members i and j in parent (n,), int32 or int64; the smaller root becomes that of both.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import find_root, unite
    >>> parent = np.arange(5, dtype=np.int32)
    >>> unite(parent, 4, 2); unite(parent, 3, 4)
    >>> [find_root(parent, i) for i in range(5)]
    [0, 1, 2, 2, 2]
    """
    i, j = find_root(parent, i), find_root(parent, j)
    parent[max(i, j)] = min(i, j)
