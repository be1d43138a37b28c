"""A binary heap of edges with their places, so that an edge's cost can be changed or the edge removed."""
from .jit import compiled

REJECTED, DEAD, LOCKED = -1, -2, -3  # values of `place` for edges that are not in the heap


@compiled
def _up(heap, place, cost, at):
    e = heap[at]
    c = cost[e]
    while at > 0:
        parent = (at - 1) >> 1
        p = heap[parent]
        if cost[p] <= c:
            break
        heap[at] = p
        place[p] = at
        at = parent
    heap[at] = e
    place[e] = at


@compiled
def _down(heap, place, cost, at, size):
    e = heap[at]
    c = cost[e]
    while True:
        child = 2 * at + 1
        if child >= size:
            break
        if child + 1 < size and cost[heap[child + 1]] < cost[heap[child]]:
            child += 1
        s = heap[child]
        if cost[s] >= c:
            break
        heap[at] = s
        place[s] = at
        at = child
    heap[at] = e
    place[e] = at


@compiled
def heapify(heap, place, cost, size):
    """Order the first `size` entries of heap (edge numbers) by cost and fill place."""
    for at in range(size):
        place[heap[at]] = at
    for at in range(size // 2 - 1, -1, -1):
        _down(heap, place, cost, at, size)


@compiled
def put(heap, place, cost, e, value, size):
    """Insert edge e with a cost, or change its cost if it is in; returns the new size."""
    at = place[e]
    if at >= 0:
        old = cost[e]
        cost[e] = value
        if value < old:
            _up(heap, place, cost, at)
        else:
            _down(heap, place, cost, at, size)
        return size
    cost[e] = value
    heap[size] = e
    place[e] = size
    _up(heap, place, cost, size)
    return size + 1


@compiled
def take(heap, place, cost, e, why, size):
    """Remove edge e if it is in the heap and set its place to `why` (REJECTED or DEAD); returns the new size."""
    at = place[e]
    if at >= 0:
        size -= 1
        last = heap[size]
        if last != e:
            heap[at] = last
            place[last] = at
            _up(heap, place, cost, at)
            _down(heap, place, cost, place[last], size)
    place[e] = why
    return size
