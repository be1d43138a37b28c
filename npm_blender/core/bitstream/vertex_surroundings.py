"""What is known about a vertex when its turn comes: its neighbours, and flaps to mirror.

Vertices come in order of number. A *flap* of vertex v is a face (v, x, y) whose edge x-y has another face (x, z, y),
all three known: numbers below v. The parallelogram rule mirrors z through the middle of x-y (Touma and Gotsman 1998).
The *pivot* is the neighbour that misses the fewest of its own neighbours: where v closes its fan, the others say much
about v.
"""
from typing import NamedTuple

import numpy as np

from ..jit import njit
from ..mesh import opposite_halfedges
from .fixed_point import log_length

FLAPS = 3                   # that are kept one by one
# places in `Surroundings.numbers`: flaps; known neighbours; pivot, -1 for none, and what it misses; sums over the flaps of
# the degrees of x and y beyond 12 and of z beyond 6, and of the edge's logarithm; logarithm of the flaps' disagreement;
# sums over the neighbours of the logarithms in `Memory.errors`; the least of the third
(COUNT, NEIGHBOURS, PIVOT, MISSING, END_DEGREES, APEX_DEGREES, EDGE, DISAGREEMENT, IN_PLANE, ALONG_NORMAL, NEAREST,
 LEAST) = range(12)
NUMBERS = 12
# rows of `Surroundings.sums`: x + y and z over the flaps, neighbours, normals of the flaps' faces, how the last flap's
# prediction differs from the first's
ENDS, APICES, CENTRE, NORMAL, DIFFERENCE = range(5)


class Surface(NamedTuple):
    """The faces as tables. All int64.

    start (n + 1,), corner (3 m,): corners of vertex v are corner[start[v]:start[v + 1]], corner 3 f + k; F (m, 3);
    opposite (3 m,): per half-edge, itself at a border; degree (n,): neighbours.
    """

    start: np.ndarray
    corner: np.ndarray
    F: np.ndarray
    opposite: np.ndarray
    degree: np.ndarray


class Memory(NamedTuple):
    """What was seen at the vertices so far. All int64.

    known (n,): neighbours that are known, and total (n, 3), their sum; errors (n, 3): 256 log2 of what the prediction was off by
    in the plane and along the normal, and of what the nearest candidate was off by; exact (n, 3): residuals that were 0.
    """

    known: np.ndarray
    total: np.ndarray
    errors: np.ndarray
    exact: np.ndarray


class Surroundings(NamedTuple):
    """Room for one vertex. All int64: numbers (12,), sums (5, 3), flaps (3, 3) predictions, copies (4, 3) neighbours."""

    numbers: np.ndarray
    sums: np.ndarray
    flaps: np.ndarray
    copies: np.ndarray


def surface_of(F: np.ndarray, n: int) -> Surface:
    """Tables of the faces F (m, 3) over n vertices. Raises MeshError if F is not an oriented manifold."""
    opposite = opposite_halfedges(F).astype(np.int64)
    F = np.ascontiguousarray(F, dtype=np.int64)
    tail = F.reshape(-1)
    corner = np.argsort(tail, kind="stable")
    degree = np.bincount(tail, minlength=n)
    start = np.concatenate([[0], np.cumsum(degree)])
    border = np.flatnonzero(opposite == np.arange(F.size))
    return Surface(start, corner, F, opposite, degree + np.bincount(tail[border], minlength=n))


def new_memory(n: int) -> Memory:
    """Nothing seen yet, of n vertices."""
    return Memory(np.zeros(n, np.int64), np.zeros((n, 3), np.int64), np.zeros((n, 3), np.int64), np.zeros((n, 3), np.int64))


def new_surroundings() -> Surroundings:
    """Room for one vertex."""
    return Surroundings(np.zeros(NUMBERS, np.int64), np.zeros((5, 3), np.int64), np.zeros((FLAPS, 3), np.int64),
                        np.zeros((4, 3), np.int64))


@njit(inline="always")
def _meet(surface, memory, room, at, u):
    """Add the known neighbour u."""
    numbers = room.numbers
    numbers[NEIGHBOURS] += 1
    for a in range(3):
        room.sums[CENTRE, a] += at[u, a]
    numbers[IN_PLANE] += memory.errors[u, 0]
    numbers[ALONG_NORMAL] += memory.errors[u, 1]
    numbers[NEAREST] += memory.errors[u, 2]
    numbers[LEAST] = min(numbers[LEAST], memory.errors[u, 2])
    missing = surface.degree[u] - memory.known[u]
    if memory.known[u] > 0 and missing < numbers[MISSING]:
        numbers[PIVOT], numbers[MISSING] = u, missing


@njit(inline="always")
def _unfold(surface, room, at, x, y, z):
    """Add the flap whose edge x-y is shared with the face (x, z, y)."""
    numbers, sums = room.numbers, room.sums
    count = numbers[COUNT]
    x0, x1, x2 = at[x, 0], at[x, 1], at[x, 2]
    y0, y1, y2 = at[y, 0] - x0, at[y, 1] - x1, at[y, 2] - x2
    z0, z1, z2 = at[z, 0] - x0, at[z, 1] - x1, at[z, 2] - x2
    sums[NORMAL, 0] += z1 * y2 - z2 * y1
    sums[NORMAL, 1] += z2 * y0 - z0 * y2
    sums[NORMAL, 2] += z0 * y1 - z1 * y0
    numbers[END_DEGREES] += min(max(surface.degree[x] + surface.degree[y] - 12, -6), 6)
    numbers[APEX_DEGREES] += min(max(surface.degree[z] - 6, -3), 3)
    numbers[EDGE] += log_length(y0, y1, y2)
    row = min(count, FLAPS - 1)
    for a in range(3):
        sums[ENDS, a] += at[x, a] + at[y, a]
        sums[APICES, a] += at[z, a]
        room.flaps[row, a] = at[x, a] + at[y, a] - at[z, a]
        sums[DIFFERENCE, a] = room.flaps[row, a] - room.flaps[0, a]
        if count < 2:
            room.copies[2 * count, a] = at[x if count == 0 else y, a]
            room.copies[2 * count + 1, a] = at[y if count == 0 else x, a]
    if count > 0:
        apart = log_length(sums[DIFFERENCE, 0], sums[DIFFERENCE, 1], sums[DIFFERENCE, 2])
        numbers[DISAGREEMENT] = apart if count == 1 else max(apart, numbers[DISAGREEMENT])
    numbers[COUNT] = count + 1


@njit
def look_around(surface, memory, room, at, v):
    """Fill `room` with what is known about vertex v; at (n, 3): positions, of which those below v are read."""
    F, opposite = surface.F, surface.opposite
    room.numbers[:] = 0
    room.sums[:] = 0
    room.numbers[PIVOT], room.numbers[MISSING], room.numbers[LEAST] = -1, 1 << 40, 1 << 40
    for i in range(surface.start[v], surface.start[v + 1]):
        h = surface.corner[i]
        f = h // 3
        k = h - 3 * f
        to_x, to_v = (k + 1) % 3, (k + 2) % 3
        x, y = F[f, to_x], F[f, to_v]
        if x < v:
            _meet(surface, memory, room, at, x)
        if y < v and opposite[3 * f + to_v] == 3 * f + to_v:
            _meet(surface, memory, room, at, y)
        if x < v and y < v:
            o = opposite[3 * f + to_x]
            if o != 3 * f + to_x:
                g = o // 3
                z = F[g, (o - 3 * g + 2) % 3]
                if z < v:
                    _unfold(surface, room, at, x, y, z)


@njit
def remember(surface, memory, at, v):
    """Tell the known neighbours of v about v, and v about them."""
    F, opposite = surface.F, surface.opposite
    for i in range(surface.start[v], surface.start[v + 1]):
        h = surface.corner[i]
        f = h // 3
        k = h - 3 * f
        into = 3 * f + (k + 2) % 3
        for turn in range(2):
            u = F[f, (k + 1 + turn) % 3]
            if u < v and (turn == 0 or opposite[into] == into):
                memory.known[u] += 1
                memory.known[v] += 1
                for a in range(3):
                    memory.total[u, a] += at[v, a]
                    memory.total[v, a] += at[u, a]
