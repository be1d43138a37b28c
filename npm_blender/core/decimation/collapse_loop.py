"""The loop over the queue: take an edge, test its collapse, flatten the stencil, record it, collapse, update the prices.

`counts` (4,) int64 holds what the loop counts, between its calls as well:

| FACES_LEFT | faces of the mesh as it is now |
| QUEUED     | edges in the queue |
| RANDOM     | state of the generator that chooses edges; 0: the cheapest edge first |
| HAS_BORDER | whether the mesh has a border (the last single face is then left to a collapse on the border) |
"""
from typing import NamedTuple

import numpy as np

from ..geometry import next_halfedge
from ..jit import compiled, is_cold
from ..parameterization import (
    ANCHORED,
    AT,
    COLLAPSES,
    EDGE,
    FACES,
    FIRST,
    INNER,
    J_START,
    J_STOP,
    MAX_RING,
    POSITIONS,
    RING,
    SIDES,
    SPARE,
    Workspace,
    flatten_jointly,
)
from .admissibility import shape_holds
from .border_corners import ALLOWED, REFUSED, corners_round, put_corners
from .edge_collapse import collapse_edge, gather_stencil, link_condition_holds
from .edge_heap import DEAD, REJECTED, take_edge
from .edge_queue import LEAST, enter, update
from .halfedge_mesh import is_border
from .quadric import best_point

FACES_LEFT, QUEUED, RANDOM, HAS_BORDER = range(4)  # entries of `counts`, see the module
DONE, MORE, EMPTY = 0, 1, 2
NEVER = -1
SINGLE = 64.0  # times the dearest price so far: above it no collapse of a single face is taken to reach a number
_CHOICES = 100  # a variant chooses among about this many of the cheapest edges
_ROOM = MAX_RING + SPARE


class Limits(NamedTuple):
    """Where the loop ends: at `target` faces, or after so many `collapses`, or from `enough` faces on when the cheapest edge
    has a price above `dear`. single: the most that the collapse of a last single face may cost; 0: SINGLE times the cheapest."""

    target: int
    collapses: int
    enough: int
    dear: float
    single: float = 0.0


class Scratch(NamedTuple):
    """Work space of one collapse: ring and faces of its `Stencil`, dead (3,) int32: edges that vanish, and that of its map."""

    ring: np.ndarray
    faces: np.ndarray
    dead: np.ndarray
    flattening: Workspace

    @staticmethod
    def make() -> "Scratch":
        """Work space for stencils of up to MAX_RING faces."""
        return Scratch(np.zeros(_ROOM, np.int32), np.zeros(_ROOM, np.int32), np.zeros(3, np.int32), Workspace.make())


@compiled(inline="always")
def _append(record, stencil, uv):
    """Append the collapse of a stencil to the record, which has room for it."""
    c, f, at = record.filled[COLLAPSES], record.filled[FACES], record.filled[POSITIONS]
    row = record.collapses[c]
    row[FIRST], row[AT], row[RING], row[SIDES] = f, at, stencil.ring_size, stencil.sides
    row[J_START], row[J_STOP] = stencil.j_start, stencil.j_stop
    faces, positions = stencil.sides + (1 if stencil.kind == EDGE else 2), stencil.ring_size + 3
    for q in range(faces):
        record.faces[f + q] = stencil.faces[q]
    for q in range(positions):
        record.uv[at + q] = uv[q]
    record.collapses[c + 1, FIRST] = f + faces
    record.filled[COLLAPSES], record.filled[FACES], record.filled[POSITIONS] = c + 1, f + faces, at + positions


@compiled(inline="always")
def _is_full(record):
    """Whether a collapse might find no room in the record."""
    return (record.filled[COLLAPSES] + 1 >= len(record.collapses) or record.filled[FACES] + _ROOM > len(record.faces)
            or record.filled[POSITIONS] + _ROOM > len(record.uv))


@compiled(inline="always")
def oriented(m, e, only_border):
    """The half-edge along which edge e collapses, and the kind of its stencil; NEVER where it may not for its ends.

    m: a HalfedgeMesh; only_border: whether inner edges may not. An end on the border stays, and an inner edge between two of them
    too, else the border would pinch.

    >>> from npm_blender.core.decimation import NEVER, half_edges_with_quadrics, oriented
    >>> from npm_blender.core.mesh import TriMesh
    >>> from npm_blender.core.parameterization import ANCHORED, EDGE
    >>> fan = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [2, 1, 4]]  # vertex 0 is inside, the others are on the border
    >>> m, _ = half_edges_with_quadrics(TriMesh.from_arrays([[0, 0, 1], [0, 1, 0], [1, 0, 0], [-1, 0, 0], [1, 1, 0]], fan))
    >>> kinds = {tuple(m.corner[[h, h - h % 3 + (h + 1) % 3]].tolist()): oriented(m, e, False) for e, h in enumerate(m.start)}
    >>> [int(kinds[ends][1]) == kind for ends, kind in (((0, 1), ANCHORED), ((1, 2), NEVER), ((1, 4), EDGE))]
    [True, True, True]
    """
    h = m.start[e]
    o = m.opposite[h]
    i, j = m.corner[h], m.corner[next_halfedge(h)]
    if m.valence[i] + m.valence[j] > MAX_RING or (only_border and o != h):
        return h, NEVER
    if o == h:
        return h, EDGE
    at_i, at_j = is_border(m, i), is_border(m, j)
    if at_i and at_j:
        return h, NEVER
    if at_j:
        return o, ANCHORED
    return h, ANCHORED if at_i else INNER


@compiled(inline="always")
def _try(m, Q, e, corners, record, scratch, tests, stage, only_border):
    """Collapse edge e if all tests allow it; returns (faces removed, ring size, surviving vertex).

    Instead of faces removed: 0 where the test of the stage refuses it, NEVER where those of topology or of the border do.
    """
    h, kind = oriented(m, e, only_border)
    if kind == NEVER:
        return NEVER, 0, h
    stencil = gather_stencil(m, h, kind, scratch.ring, scratch.faces)
    i, j = stencil.i, stencil.j
    if stencil.sides == 0 or (kind == INNER and stencil.ring_size < 3) or not link_condition_holds(stencil):
        return NEVER, 0, i
    _, x, y, z = best_point(Q, m.X, i, j)
    if not shape_holds(m.X, stencil, (x, y, z), tests.cosine[stage], tests.quality[stage]):
        return 0, 0, i
    if not flatten_jointly(m.X, stencil, (x, y, z), tests.stretch[stage], scratch.flattening):
        return 0, 0, i
    uv, r = scratch.flattening.uv, stencil.ring_size
    previous, later, corner = -1, -1, -1
    before, at, after = uv[r - 1].real, uv[r + 2].real, uv[0].real
    if kind == EDGE:
        at = 0.0 if at < 1e-9 else (1.0 if at > 1.0 - 1e-9 else at)
        previous, later, left, right, corner = corners_round(m, corners, h, before, at, after)
        if max(left, right) > corners.limits[ALLOWED]:
            corners.limits[REFUSED] = min(corners.limits[REFUSED], max(left, right))
            return NEVER, 0, i
    _append(record, stencil, uv)
    removed = collapse_edge(m, h, stencil, (x, y, z), scratch.dead)
    if kind == EDGE:
        put_corners(m, corners, i, previous, later, before, at, after, corner)
    for q in range(10):
        Q[i, q] += Q[j, q]
    return removed, r, i


@compiled(inline="always")
def _choose(counts, size):
    """The place in the queue of the edge to try next: the first, or a random one among about _CHOICES."""
    if counts[RANDOM] == 0:
        return 0
    counts[RANDOM] = (counts[RANDOM] * 6364136223846793005 + 1442695040888963407) | 1
    return ((counts[RANDOM] >> 33) & 0x3FFFFFFF) % max(min(_CHOICES, size // 8), 1)


@compiled
def run_collapses(m, Q, queue, corners, record, scratch, counts, tests, limits):
    """Collapses up to the limits; DONE at the target or a price too dear, EMPTY when no edge passes, MORE otherwise (also where
    the record is full); and the dearest price that was paid. counts: see the module.
    """
    size = counts[QUEUED]
    done = 0
    status = MORE
    dearest, single = 0.0, limits.single
    while True:
        if counts[FACES_LEFT] <= limits.target:
            status = DONE
            break
        if done >= limits.collapses or _is_full(record):
            break
        if size == 0:
            status = EMPTY
            break
        if counts[FACES_LEFT] <= limits.enough and queue.key[0] > limits.dear:
            status = DONE
            break
        e = queue.heap[_choose(counts, size)]
        size = take_edge(queue.heap, queue.key, queue.place, e, REJECTED, size)
        only_border = counts[HAS_BORDER] != 0 and counts[FACES_LEFT] == limits.target + 1
        s = queue.stage[e]
        price = tests.price[s] * (queue.error[e] + LEAST)
        if only_border:
            single = single if single > 0 else SINGLE * price
            if price > single:
                status = EMPTY
                break
        removed, ring_size, i = _try(m, Q, e, corners, record, scratch, tests, s, only_border)
        if removed <= 0:
            if removed == 0 and s + 1 < len(tests.price):
                size = enter(queue, tests, e, s + 1, size)
            else:
                queue.waiting[m.corner[m.start[e]]] = queue.waiting[m.corner[next_halfedge(m.start[e])]] = True
            continue
        done += 1
        dearest = max(dearest, price)
        counts[FACES_LEFT] -= removed
        for q in range(3):
            size = take_edge(queue.heap, queue.key, queue.place, scratch.dead[q], DEAD, size)
        size = update(m, Q, queue, tests, scratch.ring, ring_size, i, size)
    counts[QUEUED] = size
    return status, dearest


def needs_compiling() -> bool:
    """Whether the next decimation has to compile its loop first, which takes up to a minute, once on a machine.

    >>> from npm_blender.core.decimation import needs_compiling
    >>> needs_compiling() in (True, False)  # False once a mesh has been decimated
    True
    """
    return is_cold(run_collapses)
