"""Union-find over int32 parent arrays, compiled: the smallest member is the root of its set."""
from ..jit import compiled


@compiled
def find_root(parent, i):
    """Root of i, halving the path to it."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@compiled
def unite(parent, i, j):
    """Join the parts of i and j under the smaller root."""
    i, j = find_root(parent, i), find_root(parent, j)
    parent[max(i, j)] = min(i, j)
