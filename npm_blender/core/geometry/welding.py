"""Finding vertices that lie at exactly the same place (a hash table), or at nearly the same (a sweep).

The hash mixes the bits of the three coordinates with the multipliers of SplitMix64 (Steele, Lea and Flood 2014); the table is at
most half full and looks at the next slot where one is taken. The sweep goes through the points in the order of their places
along one direction: only those within reach there can be near each other. Sets of near points are joined by union-find
(see `disjoint_sets`).
"""
import numpy as np

from ..jit import compiled
from .disjoint_sets import find_root, unite

SLOPE = np.array([0.6180339887, 0.5545497331, 0.5571067812])  # a direction that no plane of a model is square to
WORK = 256  # distances computed for each point, at most: more are near each other only where there is no shape


def weld(V: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coincident rows of V (n, 3) float64, compared bit by bit (0 and -0 are the same).

    Returns first (k,) int64: the first row of each place, ascending; and place (n,) int32: V[first][place] == V.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import weld
    >>> first, place = weld(np.array([[1.0, 0, 0], [2, 0, 0], [1, -0.0, 0]]))
    >>> first.tolist(), place.tolist()
    ([0, 1], [0, 1, 0])
    """
    bits = (np.ascontiguousarray(V, dtype=np.float64) + 0.0).view(np.uint64)
    slots = 1 << max(4, int(2 * len(V)).bit_length())
    return _weld(bits, np.full(slots, -1, np.int64))


@compiled(allocates=True)
def _weld(bits, table):
    n, mask = len(bits), np.uint64(len(table) - 1)
    first, place = np.zeros(n, np.int64), np.zeros(n, np.int32)
    found = 0
    for i in range(n):
        h = bits[i, 0] * np.uint64(0x9E3779B97F4A7C15)
        h = (h ^ (h >> np.uint64(29)) ^ bits[i, 1]) * np.uint64(0xBF58476D1CE4E5B9)
        h = (h ^ (h >> np.uint64(32)) ^ bits[i, 2]) * np.uint64(0x94D049BB133111EB)
        slot = (h ^ (h >> np.uint64(31))) & mask
        while True:
            k = table[slot]
            if k < 0:
                table[slot] = found
                first[found], place[i] = i, found
                found += 1
                break
            j = first[k]
            if bits[j, 0] == bits[i, 0] and bits[j, 1] == bits[i, 1] and bits[j, 2] == bits[i, 2]:
                place[i] = k
                break
            slot = (slot + np.uint64(1)) & mask
    return first[:found].copy(), place


def near_places(V: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Smallest row joined to each row of V (n, 3), (n,) int32. Two rows are joined where their distance is below the reach
    (n,) of both, in V's unit, and so are those that others join, one by one.

    The rows must differ. After WORK n distances the rest stays apart.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import near_places
    >>> near_places(np.array([[0.0, 0, 0], [5, 0, 0], [0.8, 0, 0], [1.6, 0, 0]]), np.ones(4)).tolist()
    [0, 1, 0, 0]
    """
    along = V @ SLOPE
    order = np.argsort(along, kind="stable").astype(np.int32)
    return _near(np.ascontiguousarray(V), reach, along, order, WORK * len(V))


@compiled(allocates=True)
def _near(V, reach, along, order, work):
    parent = np.arange(len(V)).astype(np.int32)
    for i in range(len(order)):
        a = order[i]
        for j in range(i + 1, len(order)):
            b = order[j]
            if along[b] - along[a] >= reach[a] or work < 0:
                break
            work -= 1
            near = min(reach[a], reach[b])
            x, y, z = V[a, 0] - V[b, 0], V[a, 1] - V[b, 1], V[a, 2] - V[b, 2]
            if x * x + y * y + z * z < near * near:
                unite(parent, a, b)
    for i in range(len(V)):
        parent[i] = find_root(parent, i)
    return parent
