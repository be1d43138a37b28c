"""Connected parts of a graph given by pairs, in NumPy alone (min-label propagation with pointer jumping)."""
import numpy as np


def component_labels(n: int, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Smallest member of each node's part, (n,) int64, for n nodes joined by the pairs a[i]-b[i].

    Every node takes the smallest label of its neighbours and then jumps to its label's label, until nothing changes (after
    Shiloach and Vishkin 1982).

    >>> import numpy as np
    >>> from npm_blender.core.mesh import component_labels
    >>> component_labels(5, np.array([4, 1]), np.array([1, 3])).tolist()  # 4-1, 1-3
    [0, 1, 2, 1, 1]
    """
    root = np.arange(n, dtype=np.int64)
    while True:
        low = np.minimum(root[a], root[b])
        before = root.copy()
        np.minimum.at(root, root[a], low)
        np.minimum.at(root, root[b], low)
        while True:
            jumped = root[root]
            if (jumped == root).all():
                break
            root = jumped
        if (root == before).all():
            return root


def count_roots(owner: np.ndarray, a: np.ndarray, b: np.ndarray, n: int) -> np.ndarray:
    """Number of parts among the nodes of each owner, (n,) int32; owner[i] in 0..n-1 owns node i, pairs a-b join nodes."""
    parts = component_labels(len(owner), a, b)
    roots = np.unique(parts)
    return np.bincount(owner[roots], minlength=n).astype(np.int32)
