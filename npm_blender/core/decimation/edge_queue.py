"""The queue of edges: each at the price of its collapse under the tests that it meets next."""
from typing import NamedTuple

import numpy as np

from ..geometry import next_halfedge, prev_halfedge
from ..jit import compiled
from .edge_heap import LOCKED, REJECTED, heapify_edges, put_edge
from .quadric import best_point

LEAST = 1e-10  # added to an edge's error (squared distance times area, unit frame): a flat edge has its price as well
_BUSY = 32  # rejected edges at vertices with more faces wait until the vertex itself changes


class Queue(NamedTuple):
    """Edges by price: heap, key and place (see edge_heap); error (e,) float64, stage (e,) int8, waiting (n,) bool.

    error: the quadric's; stage: the number of the test that the edge meets next, which says its price (see `AdmissibilityTest`);
    waiting: vertices whose edges may be rejected ones, which wait for something to change round them.
    """

    heap: np.ndarray
    key: np.ndarray
    place: np.ndarray
    error: np.ndarray
    stage: np.ndarray
    waiting: np.ndarray


@compiled(inline="always")
def enter(queue, tests, e, stage, size):
    """Put edge e into the queue for a test, unless it is locked; returns the new size."""
    if queue.place[e] == LOCKED:
        return size
    queue.stage[e] = stage
    return put_edge(queue.heap, queue.key, queue.place, e, tests.price[stage] * (queue.error[e] + LEAST), size)


@compiled
def offer(queue, tests, edges):
    """Make these edges (k,) the queue, for the first test; no other edge may be in it."""
    for k in range(len(edges)):
        e = edges[k]
        queue.heap[k], queue.stage[e], queue.key[k] = e, 0, tests.price[0] * (queue.error[e] + LEAST)
    heapify_edges(queue.heap, queue.key, queue.place, len(edges))


@compiled(inline="always")
def _update_vertex(m, Q, queue, tests, i, size):
    """New prices of the edges at vertex i, all for the first test."""
    h = first = m.out[i]
    while True:
        e = m.edge[h]
        queue.error[e], _, _, _ = best_point(Q, m.X, i, m.corner[next_halfedge(h)])
        size = enter(queue, tests, e, 0, size)
        p = prev_halfedge(h)
        h = m.opposite[p]
        if h == p:
            e = m.edge[p]
            queue.error[e], _, _, _ = best_point(Q, m.X, i, m.corner[p])
            size = enter(queue, tests, e, 0, size)
            break
        if h == first:
            break
    return size


@compiled(inline="always")
def _offer_rejected(m, queue, tests, v, size):
    """Put the rejected edges at vertex v into the queue, for the first test."""
    h = first = m.out[v]
    while True:
        e = m.edge[h]
        if queue.place[e] == REJECTED:
            size = enter(queue, tests, e, 0, size)
        p = prev_halfedge(h)
        h = m.opposite[p]
        if h == p:
            e = m.edge[p]
            if queue.place[e] == REJECTED:
                size = enter(queue, tests, e, 0, size)
            break
        if h == first:
            break
    return size


@compiled(inline="always")
def update(m, Q, queue, tests, ring, ring_size, i, size):
    """New prices round vertex i, and another chance for the rejected edges at its ring; returns the new size."""
    size = _update_vertex(m, Q, queue, tests, i, size)
    for q in range(ring_size):
        v = ring[q]
        if queue.waiting[v] and m.valence[v] <= _BUSY:
            queue.waiting[v] = False
            size = _offer_rejected(m, queue, tests, v, size)
    return size
