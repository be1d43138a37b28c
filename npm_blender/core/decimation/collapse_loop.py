"""The loop over the queue: pop an edge, test its collapse, flatten the patch, record, collapse, update the costs."""
from typing import NamedTuple

import numpy as np

from ..geometry import next_halfedge, prev_halfedge
from ..jit import compiled, is_cold
from ..parameterization import ANCHORED, AT, EDGE, FIRST, INNER, MAX_RING, RING, S1, S2, SIDES, flatten_jointly
from .border_corners import corners_round, put_corners
from .edge_heap import DEAD, LOCKED, REJECTED, heapify_edges, put_edge, take_edge
from .halfedge_mesh import collapse_edge, gather_stencil, is_border, link_condition_holds
from .quadric import best_point

DONE, MORE, EMPTY = 0, 1, 2
NEVER = -1
LEAST = 1e-10  # added to an edge's error (squared distance times area, unit frame): a flat edge has its price as well
_BUSY = 32  # rejected edges at vertices with more faces wait until the vertex itself changes
_CHOICES = 100  # a variant chooses among about this many of the cheapest edges


class Queue(NamedTuple):
    """Edges by price: heap, key and place (see edgeheap); error (e,) float64, stage (e,) int8.

    error: the quadric's; stage: the tests that the edge meets next, which say its price (see `decimate.AdmissibilityTest`);
    waiting (n,) bool: vertices whose edges may be rejected ones, which wait for something to change round them.
    """

    heap: np.ndarray
    key: np.ndarray
    place: np.ndarray
    error: np.ndarray
    stage: np.ndarray
    waiting: np.ndarray


class Tests(NamedTuple):
    """`decimate.STAGES` as arrays, one entry a stage."""

    price: np.ndarray
    cosine: np.ndarray
    quality: np.ndarray
    stretch: np.ndarray


class Scratch(NamedTuple):
    """Work space of one collapse."""

    ring: np.ndarray
    face: np.ndarray
    dead: np.ndarray
    uv: np.ndarray
    cots: np.ndarray
    S: np.ndarray
    B: np.ndarray
    A: np.ndarray

    @staticmethod
    def make() -> "Scratch":
        """Work space for patches of up to MAX_RING faces."""
        n = MAX_RING + 8
        return Scratch(
            ring=np.zeros(n, np.int32), face=np.zeros(n, np.int32), dead=np.zeros(3, np.int32),
            uv=np.zeros(n, np.complex128), cots=np.zeros((2 * n, 3)), S=np.zeros((n, 6), np.complex128),
            B=np.zeros((3, 4), np.complex128), A=np.zeros((6, 7)))


@compiled
def _normal(ax, ay, az, bx, by, bz, cx, cy, cz):
    """Area-weighted normal of a triangle, and the sum of its squared sides."""
    ux, uy, uz = bx - ax, by - ay, bz - az
    vx, vy, vz = cx - ax, cy - ay, cz - az
    wx, wy, wz = cx - bx, cy - by, cz - bz
    sides = ux * ux + uy * uy + uz * uz + vx * vx + vy * vy + vz * vz + wx * wx + wy * wy + wz * wz
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx, sides


@compiled
def shape_holds(X, ring, r, t, s1, s2, i, j, x, y, z, cosine, quality):
    """Whether no ring face turns by more than `orientation_cosine` allows, or gets worse than `quality` and the worst before."""
    worst_before = worst_after = 1.0
    for q in range(t):
        a, b = ring[q], ring[q + 1 if q + 1 < r else 0]
        o = j if s1 <= q < s2 else i
        ax, ay, az, bx, by, bz = X[a, 0], X[a, 1], X[a, 2], X[b, 0], X[b, 1], X[b, 2]
        n0, n1, n2, l0 = _normal(X[o, 0], X[o, 1], X[o, 2], ax, ay, az, bx, by, bz)
        p0, p1, p2, l1 = _normal(x, y, z, ax, ay, az, bx, by, bz)
        n, p = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2), np.sqrt(p0 * p0 + p1 * p1 + p2 * p2)
        if n0 * p0 + n1 * p1 + n2 * p2 < cosine * n * p:
            return False
        worst_before = min(worst_before, 3.4641 * n / max(l0, 1e-300))
        worst_after = min(worst_after, 3.4641 * p / max(l1, 1e-300))
    return worst_after >= min(quality, worst_before)


@compiled(inline="always")
def _record(hist, counts, scratch, r, t, s1, s2, gone):
    """Append the collapse in `scratch` to the history; gone: number of faces that vanish."""
    c, f, at = counts[2], counts[3], counts[4]
    row = hist.collapses[c]
    row[FIRST], row[AT], row[RING], row[SIDES], row[S1], row[S2] = f, at, r, t, s1, s2
    for q in range(t + gone):
        hist.faces[f + q] = scratch.face[q]
    for q in range(r + 3):
        hist.uv[at + q] = scratch.uv[q]
    hist.collapses[c + 1, FIRST] = f + t + gone
    counts[2], counts[3], counts[4] = c + 1, f + t + gone, at + r + 3


@compiled(inline="always")
def _enter(queue, tests, e, stage, size):
    """Put edge e into the queue for the tests of a stage, unless it is locked; returns the new size."""
    if queue.place[e] == LOCKED:
        return size
    queue.stage[e] = stage
    return put_edge(queue.heap, queue.key, queue.place, e, tests.price[stage] * (queue.error[e] + LEAST), size)


@compiled
def offer(queue, tests, edges):
    """Make these edges (k,) the queue, for the first tests; no other edge may be in it."""
    for k in range(len(edges)):
        e = edges[k]
        queue.heap[k], queue.stage[e], queue.key[k] = e, 0, tests.price[0] * (queue.error[e] + LEAST)
    heapify_edges(queue.heap, queue.key, queue.place, len(edges))


@compiled(inline="always")
def _update(m, Q, queue, tests, ring, r, i, size):
    """New costs round vertex i; rejected edges of the ring get another chance."""
    h = first = m.out[i]
    while True:
        e = m.edge[h]
        queue.error[e], _, _, _ = best_point(Q, m.X, i, m.corner[next_halfedge(h)])
        size = _enter(queue, tests, e, 0, size)
        p = prev_halfedge(h)
        h = m.opposite[p]
        if h == p:
            e = m.edge[p]
            queue.error[e], _, _, _ = best_point(Q, m.X, i, m.corner[p])
            size = _enter(queue, tests, e, 0, size)
            break
        if h == first:
            break
    for q in range(r):
        if not queue.waiting[ring[q]] or m.valence[ring[q]] > _BUSY:
            continue
        queue.waiting[ring[q]] = False
        h = first = m.out[ring[q]]
        while True:
            e = m.edge[h]
            if queue.place[e] == REJECTED:
                size = _enter(queue, tests, e, 0, size)
            p = prev_halfedge(h)
            h = m.opposite[p]
            if h == p:
                e = m.edge[p]
                if queue.place[e] == REJECTED:
                    size = _enter(queue, tests, e, 0, size)
                break
            if h == first:
                break
    return size


@compiled(inline="always")
def _try(m, Q, e, corners, hist, scratch, counts, only_border, cosine, quality, stretch):
    """Collapse edge e if all tests allow it; returns (faces removed, ring size, surviving vertex).

    Instead of faces removed: 0 where the tests of the stage refuse it, NEVER where those of topology or of the border do.
    """
    h = m.start[e]
    o = m.opposite[h]
    i, j = m.corner[h], m.corner[next_halfedge(h)]
    if m.valence[i] + m.valence[j] > MAX_RING or (only_border and o != h):
        return NEVER, 0, i
    kind = INNER
    if o == h:
        kind = EDGE
    else:
        at_i, at_j = is_border(m, i), is_border(m, j)
        if at_i and at_j:
            return NEVER, 0, i
        if at_i or at_j:
            kind = ANCHORED
        if at_j:
            h, o, i, j = o, h, j, i
    r, t, s1, s2 = gather_stencil(m, h, kind, scratch.ring, scratch.face)
    if t == 0 or (kind == INNER and r < 3) or not link_condition_holds(scratch.ring, r, s1, s2):
        return NEVER, 0, i
    _, x, y, z = best_point(Q, m.X, i, j)
    if not shape_holds(m.X, scratch.ring, r, t, s1, s2, i, j, x, y, z, cosine, quality):
        return 0, 0, i
    if not flatten_jointly(m.X, scratch.ring, r, t, s1, s2, kind, i, j, x, y, z, stretch, scratch.uv, scratch.cots,
                   scratch.S, scratch.B, scratch.A):
        return 0, 0, i
    previous, later, corner = -1, -1, -1
    before, at, after = scratch.uv[r - 1].real, scratch.uv[r + 2].real, scratch.uv[0].real
    if kind == EDGE:
        at = 0.0 if at < 1e-9 else (1.0 if at > 1.0 - 1e-9 else at)
        previous, later, left, right, corner = corners_round(m, corners, h, before, at, after)
        if max(left, right) > corners.limits[0]:
            corners.limits[1] = min(corners.limits[1], max(left, right))
            return NEVER, 0, i
    _record(hist, counts, scratch, r, t, s1, s2, 1 if kind == EDGE else 2)
    removed = collapse_edge(m, h, kind, x, y, z, scratch.face, t, s1, s2, scratch.dead)
    if kind == EDGE:
        put_corners(m, corners, i, previous, later, before, at, after, corner)
    for q in range(10):
        Q[i, q] += Q[j, q]
    return removed, r, i


@compiled
def run_collapses(m, Q, queue, corners, hist, scratch, counts, target, collapses, tests, enough, dear):
    """Up to `collapses` collapses; DONE at the target, EMPTY when no edge passes, MORE otherwise (also: history full).

    Also DONE from `enough` faces on when the cheapest edge has a price above `dear`.

    counts: faces, queue size, collapses, faces and positions of the history, random state (0: cheapest first), whether the
    mesh has a border (the last single face is then left to a collapse on the border).
    """
    size = counts[1]
    spare = MAX_RING + 8
    done = 0
    status = MORE
    while True:
        if counts[0] <= target:
            status = DONE
            break
        if (done >= collapses or counts[2] + 1 >= len(hist.collapses)
                or counts[3] + spare > len(hist.faces) or counts[4] + spare > len(hist.uv)):
            break
        if size == 0:
            status = EMPTY
            break
        if counts[0] <= enough and queue.key[0] > dear:
            status = DONE
            break
        at = 0
        if counts[5] != 0:
            counts[5] = (counts[5] * 6364136223846793005 + 1442695040888963407) | 1
            at = ((counts[5] >> 33) & 0x3FFFFFFF) % max(min(_CHOICES, size // 8), 1)
        e = queue.heap[at]
        size = take_edge(queue.heap, queue.key, queue.place, e, REJECTED, size)
        only_border = counts[6] != 0 and counts[0] == target + 1
        s = queue.stage[e]
        removed, r, i = _try(m, Q, e, corners, hist, scratch, counts, only_border, tests.cosine[s], tests.quality[s],
                             tests.stretch[s])
        if removed <= 0:
            if removed == 0 and s + 1 < len(tests.price):
                size = _enter(queue, tests, e, s + 1, size)
            else:
                queue.waiting[m.corner[m.start[e]]] = queue.waiting[m.corner[next_halfedge(m.start[e])]] = True
            continue
        done += 1
        counts[0] -= removed
        for q in range(3):
            size = take_edge(queue.heap, queue.key, queue.place, scratch.dead[q], DEAD, size)
        size = _update(m, Q, queue, tests, scratch.ring, r, i, size)
    counts[1] = size
    return status


def needs_compiling() -> bool:
    """Whether the next decimation has to compile its loop first, which takes up to a minute, once on a machine."""
    return is_cold(run_collapses)
