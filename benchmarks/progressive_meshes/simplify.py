"""Edge collapses by quadric error (Garland and Heckbert 1997), in batches of collapses that do not touch each other.

Batches are what makes naming the split vertex cheap (Pajarola and Rossignac 2000): a flag for each vertex that could be
split. A batch takes the cheapest edges whose ends no collapse of the batch has moved or surrounded, so the order stays
close to the order of errors.
"""

from dataclasses import dataclass

import numpy as np

from npm_blender.core.decimation import (
    DEAD,
    REJECTED,
    best_point,
    collapse_edge,
    edge_costs,
    gather_stencil,
    half_edges_with_quadrics,
    heapify_edges,
    is_border,
    link_condition_holds,
    put_edge,
    shape_holds,
    take_edge,
)
from npm_blender.core.geometry import next_halfedge, prev_halfedge
from npm_blender.core.jit import compiled
from npm_blender.core.mesh import TriMesh
from npm_blender.core.parameterization import ANCHORED, EDGE, INNER, MAX_RING, SPARE

SHARE = 8  # a batch collapses at most one vertex in SHARE
DEARER = 4.0  # and no edge that costs this many times more than that share's dearest edge
_TESTS = ((0.2, 0.01), (0.0, 0.001), (-0.9, 0.0))  # least cosine between normals, least face quality; then milder ones


@dataclass(frozen=True)
class Collapses:
    """What was collapsed, first to last, and what was left.

    ends (c, 2) int32: kept and removed vertex; cuts (c, 2) int32: ring vertices at which the removed vertex's faces
    begin and end, -1 first where the collapsed edge was on the border; at (c, 2, 3) float64: positions of both before;
    batch (c,) int32; cost (c,) float64: quadric error; X (n, 3): positions now; F (m, 3): faces left, input's numbers.
    """

    ends: np.ndarray
    cuts: np.ndarray
    at: np.ndarray
    batch: np.ndarray
    cost: np.ndarray
    X: np.ndarray
    F: np.ndarray


@compiled
def _touch(m, Q, heap, cost, place, i, size):
    """New costs of the edges at vertex i."""
    h = first = m.out[i]
    while True:
        e = m.edge[h]
        c, _, _, _ = best_point(Q, m.X, i, m.corner[next_halfedge(h)])
        size = put_edge(heap, cost, place, e, c, size)
        p = prev_halfedge(h)
        h = m.opposite[p]
        if h == p:
            e = m.edge[p]
            c, _, _, _ = best_point(Q, m.X, i, m.corner[p])
            return put_edge(heap, cost, place, e, c, size)
        if h == first:
            return size


@compiled(allocates=True)
def _batch(m, Q, heap, cost, place, size, faces, target, most, limit, cosine, quality, blocked, b, counts, ends, cuts, at,
           batch, error, aside, aside_cost):
    """One batch; returns queue size, faces left and number of collapses so far."""
    ring, face = np.zeros(MAX_RING + SPARE, np.int32), np.zeros(MAX_RING + SPARE, np.int32)
    dead = np.zeros(3, np.int32)
    done, waiting, first = counts[0], 0, counts[0]
    while size > 0 and faces > target and done - first < most and cost[0] <= limit:
        e = heap[0]
        c = cost[0]
        size = take_edge(heap, cost, place, e, REJECTED, size)
        h = m.start[e]
        o = m.opposite[h]
        i, j = m.corner[h], m.corner[next_halfedge(h)]
        if blocked[i] == b or blocked[j] == b:
            aside[waiting], aside_cost[waiting] = e, c
            waiting += 1
            continue
        if m.valence[i] + m.valence[j] > 40:
            continue
        kind = INNER
        if o == h:
            kind = EDGE
        else:
            at_i, at_j = is_border(m, i), is_border(m, j)
            if at_i and at_j:
                continue
            if at_i or at_j:
                kind = ANCHORED
            if at_j:
                h, o, i, j = o, h, j, i
        stencil = gather_stencil(m, h, kind, ring, face)
        if stencil.sides == 0 or (kind == INNER and stencil.ring_size < 3) or not link_condition_holds(stencil):
            continue
        _, x, y, z = best_point(Q, m.X, i, j)
        if not shape_holds(m.X, stencil, (x, y, z), cosine, quality):
            continue
        ends[done, 0], ends[done, 1] = i, j
        cuts[done, 0], cuts[done, 1] = -1 if kind == EDGE else ring[stencil.j_start], ring[stencil.j_stop]
        for k in range(3):
            at[done, 0, k], at[done, 1, k] = m.X[i, k], m.X[j, k]
        batch[done], error[done] = b, c
        done += 1
        faces -= collapse_edge(m, h, stencil, (x, y, z), dead)
        for q in range(10):
            Q[i, q] += Q[j, q]
        for q in range(3):
            size = take_edge(heap, cost, place, dead[q], DEAD, size)
        size = _touch(m, Q, heap, cost, place, i, size)
        blocked[i] = b
        for q in range(stencil.ring_size):
            blocked[ring[q]] = b
    for q in range(waiting):
        e = aside[q]
        if place[e] == REJECTED:
            size = put_edge(heap, cost, place, e, aside_cost[q], size)
    counts[0] = done
    return size, faces


def simplify(mesh: TriMesh, target: int) -> Collapses:
    """Collapse an oriented manifold mesh to about `target` faces. Raises MeshError if it is not a manifold."""
    m, Q = half_edges_with_quadrics(mesh)
    n, faces = len(mesh.V), len(mesh.F)
    cost = edge_costs(Q, m.X, m.corner, m.start)
    place = np.full(len(m.start), REJECTED, np.int32)
    heap, aside = np.arange(len(m.start), dtype=np.int32), np.zeros(len(m.start), np.int32)
    aside_cost = np.zeros(len(aside))
    heapify_edges(heap, cost, place, len(heap))
    size = len(heap)
    blocked, counts = np.full(n, -1, np.int64), np.zeros(1, np.int64)
    ends, cuts, batch = np.zeros((n, 2), np.int32), np.zeros((n, 2), np.int32), np.zeros(n, np.int32)
    at, error = np.zeros((n, 2, 3)), np.zeros(n)
    stage, b = 0, 0
    while faces > target:
        most = max((n - counts[0]) // SHARE, 1)
        queued = cost[:size]
        limit = np.inf if size <= most else DEARER * np.partition(queued, most)[most] + 1e-16
        before = counts[0]
        size, faces = _batch(m, Q, heap, cost, place, size, faces, target, most, limit, *_TESTS[stage], blocked, b, counts,
                             ends, cuts, at, batch, error, aside, aside_cost)
        b += 1
        if counts[0] == before and size == 0:
            if stage + 1 == len(_TESTS):
                break
            stage += 1
            again = np.flatnonzero(place == REJECTED).astype(np.int32)
            size = len(again)
            heap[:size], cost[:size] = again, edge_costs(Q, m.X, m.corner, m.start[again])
            heapify_edges(heap, cost, place, size)
        elif stage and counts[0] - before > most // 2:
            stage = 0
    c = int(counts[0])
    corner = m.corner.reshape(-1, 3)
    return Collapses(ends[:c], cuts[:c], at[:c], batch[:c], error[:c], m.X, corner[corner[:, 0] >= 0].copy())
