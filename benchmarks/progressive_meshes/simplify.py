"""Edge collapses by quadric error (Garland and Heckbert 1997), in batches of collapses that do not touch each other.

Batches are what makes naming the split vertex cheap (Pajarola and Rossignac 2000): a flag for each vertex that could be
split. A batch takes the cheapest edges whose ends no collapse of the batch has moved or surrounded, so the order stays
close to the order of errors.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from npm_blender.core.decimation import (
    DEAD,
    NEVER,
    REJECTED,
    best_point,
    collapse_edge,
    edge_costs,
    gather_stencil,
    half_edges_with_quadrics,
    heapify_edges,
    link_condition_holds,
    oriented,
    put_edge,
    shape_holds,
    take_edge,
)
from npm_blender.core.geometry import next_halfedge, prev_halfedge
from npm_blender.core.jit import compiled
from npm_blender.core.mesh import TriMesh
from npm_blender.core.parameterization import EDGE, INNER, MAX_RING

SHARE = 8  # a batch collapses at most one vertex in SHARE
DEARER = 4.0  # and no edge that costs this many times more than that share's dearest edge
_TESTS = ((0.2, 0.01), (0.0, 0.001), (-0.9, 0.0))  # least cosine between normals, least face quality; then milder ones
_MAX_VALENCES = 40  # of both ends of a collapsed edge
KEPT, REMOVED = 0, 1  # columns of Collapses.ends and at
BEGIN, END = 0, 1  # columns of Collapses.cuts


@dataclass(frozen=True)
class Collapses:
    """What was collapsed, first to last, and what was left.

    ends (c, 2) int32: the KEPT and the REMOVED vertex; cuts (c, 2) int32: the neighbours at which the removed vertex's faces
    BEGIN and END, BEGIN -1 where the collapsed edge was on the border; at (c, 2, 3) float64: positions of both before;
    batch (c,) int32; cost (c,) float64: quadric error; X (n, 3): positions now; F (m, 3): faces left, input's numbers.
    """

    ends: np.ndarray
    cuts: np.ndarray
    at: np.ndarray
    batch: np.ndarray
    cost: np.ndarray
    X: np.ndarray
    F: np.ndarray


class Queue(NamedTuple):
    """Edges by cost: heap (e,) int32, the cheapest first; cost (e,): of heap's entries; place (e,): of each edge in heap."""

    heap: np.ndarray
    cost: np.ndarray
    place: np.ndarray


class Rules(NamedTuple):
    """target: faces at the end; of one batch most: collapses, dearest: cost; cosine, quality: of faces, see shape_holds."""

    target: int
    most: int
    dearest: float
    cosine: float
    quality: float


class Progress(NamedTuple):
    """Number of the next batch, edges in the queue, faces left, collapses done."""

    batch: int
    queued: int
    faces: int
    done: int


class Log(NamedTuple):
    """Room for a row of each collapse, as in Collapses."""

    ends: np.ndarray
    cuts: np.ndarray
    at: np.ndarray
    batch: np.ndarray
    cost: np.ndarray


class Workspace(NamedTuple):
    """blocked (n,) int64: the last batch that moved or surrounded each vertex; aside (e,) int32, aside_cost (e,): edges that
    wait for the next batch; ring, face, dead: the neighbours, faces and dead edges of one collapse."""

    blocked: np.ndarray
    aside: np.ndarray
    aside_cost: np.ndarray
    ring: np.ndarray
    face: np.ndarray
    dead: np.ndarray

    @staticmethod
    def of(vertices: int, edges: int) -> "Workspace":
        """For a mesh of so many vertices and edges."""
        ring, face = np.zeros(MAX_RING + 8, np.int32), np.zeros(MAX_RING + 8, np.int32)
        return Workspace(np.full(vertices, -1, np.int64), np.zeros(edges, np.int32), np.zeros(edges), ring, face,
                         np.zeros(3, np.int32))


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


@compiled
def _note(log, done, X, i, j, begin, end):
    """Row of a collapse of j into i."""
    log.ends[done, KEPT], log.ends[done, REMOVED] = i, j
    log.cuts[done, BEGIN], log.cuts[done, END] = begin, end
    for k in range(3):
        log.at[done, KEPT, k], log.at[done, REMOVED, k] = X[i, k], X[j, k]


@compiled
def _batch(m, Q, queue, now, rules, log, work):
    """One batch, from the Progress `now`; returns the Progress after it."""
    heap, cost, place = queue.heap, queue.cost, queue.place
    ring, face, dead, blocked = work.ring, work.face, work.dead, work.blocked
    cosine, quality = rules.cosine, rules.quality
    size, faces, done, waiting = now.queued, now.faces, now.done, 0
    while size > 0 and faces > rules.target and done - now.done < rules.most and cost[0] <= rules.dearest:
        e = heap[0]
        c = cost[0]
        size = take_edge(heap, cost, place, e, REJECTED, size)
        h = m.start[e]
        i, j = m.corner[h], m.corner[next_halfedge(h)]
        if blocked[i] == now.batch or blocked[j] == now.batch:
            work.aside[waiting], work.aside_cost[waiting] = e, c
            waiting += 1
            continue
        h, kind = oriented(m, e, False)
        if kind == NEVER or m.valence[i] + m.valence[j] > _MAX_VALENCES:
            continue
        i, j = m.corner[h], m.corner[next_halfedge(h)]
        stencil = gather_stencil(m, h, kind, ring, face)
        if stencil.sides == 0 or (kind == INNER and stencil.ring_size < 3) or not link_condition_holds(stencil):
            continue
        _, x, y, z = best_point(Q, m.X, i, j)
        if not shape_holds(m.X, stencil, (x, y, z), cosine, quality):
            continue
        _note(log, done, m.X, i, j, -1 if kind == EDGE else ring[stencil.j_start], ring[stencil.j_stop])
        log.batch[done], log.cost[done] = now.batch, c
        done += 1
        faces -= collapse_edge(m, h, stencil, (x, y, z), dead)
        for q in range(10):
            Q[i, q] += Q[j, q]
        for q in range(3):
            size = take_edge(heap, cost, place, dead[q], DEAD, size)
        size = _touch(m, Q, heap, cost, place, i, size)
        blocked[i] = now.batch
        for q in range(stencil.ring_size):
            blocked[ring[q]] = now.batch
    for q in range(waiting):
        e = work.aside[q]
        if place[e] == REJECTED:
            size = put_edge(heap, cost, place, e, work.aside_cost[q], size)
    return Progress(now.batch + 1, size, faces, done)


def simplify(mesh: TriMesh, target: int) -> Collapses:
    """Collapse an oriented manifold mesh to about `target` faces. Raises MeshError if it is not a manifold."""
    m, Q = half_edges_with_quadrics(mesh)
    n, edges = len(mesh.V), len(m.start)
    cost = edge_costs(Q, m.X, m.corner, m.start)
    heap, place = np.arange(edges, dtype=np.int32), np.full(edges, REJECTED, np.int32)
    heapify_edges(heap, cost, place, len(heap))
    queue, work = Queue(heap, cost, place), Workspace.of(n, edges)
    log = Log(np.zeros((n, 2), np.int32), np.zeros((n, 2), np.int32), np.zeros((n, 2, 3)), np.zeros(n, np.int32), np.zeros(n))
    now, stage = Progress(0, edges, len(mesh.F), 0), 0
    while now.faces > target:
        most = max((n - now.done) // SHARE, 1)
        dearest = np.inf if now.queued <= most else DEARER * np.partition(cost[:now.queued], most)[most] + 1e-16
        before = now.done
        now = _batch(m, Q, queue, now, Rules(target, most, dearest, *_TESTS[stage]), log, work)
        if now.done == before and now.queued == 0:
            if stage + 1 == len(_TESTS):
                break
            stage += 1
            again = np.flatnonzero(place == REJECTED).astype(np.int32)
            size = len(again)
            heap[:size], cost[:size] = again, edge_costs(Q, m.X, m.corner, m.start[again])
            heapify_edges(heap, cost, place, size)
            now = now._replace(queued=size)
        elif stage and now.done - before > most // 2:
            stage = 0
    corner = m.corner.reshape(-1, 3)
    return Collapses(*(rows[:now.done] for rows in log), m.X, corner[corner[:, 0] >= 0].copy())
