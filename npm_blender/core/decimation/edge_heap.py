"""A binary heap of edges with their places, so that an edge's price can be changed or the edge removed.

heap (e,) int32 and key (e,) float64: edges and their prices, in the order of the heap, where children lie side by side;
place (e,) int32: where in the heap each edge is.
"""
from ..jit import compiled

REJECTED, DEAD, LOCKED = -1, -2, -3  # values of `place` for edges that are not in the heap


@compiled
def _up(heap, key, place, at, e, price):
    """Put edge e at a place that is free, or above."""
    while at > 0:
        parent = (at - 1) >> 1
        if key[parent] <= price:
            break
        heap[at], key[at] = heap[parent], key[parent]
        place[heap[at]] = at
        at = parent
    heap[at], key[at] = e, price
    place[e] = at


@compiled
def _down(heap, key, place, at, e, price, size):
    """Put edge e at a place that is free, or below."""
    child = 2 * at + 1
    while child < size:
        if child + 1 < size:
            child += key[child + 1] < key[child]
        if key[child] >= price:
            break
        heap[at], key[at] = heap[child], key[child]
        place[heap[at]] = at
        at = child
        child = 2 * at + 1
    heap[at], key[at] = e, price
    place[e] = at


@compiled
def heapify_edges(heap, key, place, size):
    """Order the first `size` entries of heap and key, and fill place (Floyd 1964).

    A binary heap: heap[0] is the cheapest edge, and key[(a - 1) // 2] <= key[a] for a > 0. heap (e,) int32, key (e,) float64,
    place (e,) int32 are changed in place; place[heap[a]] == a.

    >>> import numpy as np
    >>> from npm_blender.core.decimation import heapify_edges
    >>> heap, key, place = np.arange(3, dtype=np.int32), np.array([5.0, 4.0, 3.0]), np.zeros(3, np.int32)
    >>> heapify_edges(heap, key, place, 3)
    >>> heap.tolist(), key.tolist(), place.tolist()
    ([2, 1, 0], [3.0, 4.0, 5.0], [2, 1, 0])
    """
    for at in range(size):
        place[heap[at]] = at
    for at in range(size // 2 - 1, -1, -1):
        _down(heap, key, place, at, heap[at], key[at], size)


@compiled
def put_edge(heap, key, place, e, price, size):
    """Insert edge e at a price, or change its price if it is in; returns the new size (Williams 1964).

    >>> import numpy as np
    >>> from npm_blender.core.decimation import REJECTED, put_edge
    >>> heap, key, place = np.zeros(3, np.int32), np.zeros(3), np.full(3, REJECTED, np.int32)
    >>> size = put_edge(heap, key, place, 2, 7.0, 0)
    >>> size = put_edge(heap, key, place, 0, 6.0, size)
    >>> int(put_edge(heap, key, place, 2, 5.0, size)), heap[:2].tolist()  # edge 2 is cheaper now, and comes first
    (2, [2, 0])
    """
    at = place[e]
    if at < 0:
        _up(heap, key, place, size, e, price)
        return size + 1
    if price < key[at]:
        _up(heap, key, place, at, e, price)
    else:
        _down(heap, key, place, at, e, price, size)
    return size


@compiled
def take_edge(heap, key, place, e, why, size):
    """Remove edge e if it is in the heap and set its place to `why` (REJECTED or DEAD); returns the new size (Williams 1964).

    >>> import numpy as np
    >>> from npm_blender.core.decimation import DEAD, REJECTED, heapify_edges, take_edge
    >>> heap, key, place = np.arange(3, dtype=np.int32), np.array([3.0, 4.0, 5.0]), np.zeros(3, np.int32)
    >>> heapify_edges(heap, key, place, 3)
    >>> int(take_edge(heap, key, place, 0, DEAD, 3)), heap[:2].tolist(), int(place[0]) == DEAD
    (2, [1, 2], True)
    """
    at = place[e]
    if at >= 0:
        size -= 1
        if at < size:
            if at > 0 and key[(at - 1) >> 1] > key[size]:
                _up(heap, key, place, at, heap[size], key[size])
            else:
                _down(heap, key, place, at, heap[size], key[size], size)
    place[e] = why
    return size
