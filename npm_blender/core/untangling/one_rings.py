"""The one-rings of all vertices of levels 1..L: the neighbours and faces round each, in the order in which they lie."""
from typing import NamedTuple

import numpy as np

from ..geometry import prev_halfedge
from ..jit import compiled
from ..mesh import Level


class OneRings(NamedTuple):
    """Levels 1..L in one, as compressed rows. Faces F (m, 3), concatenated; first (L + 1,): the first face of each level, and
    the end.

    around[at[k, v]:at[k, v + 1]]: the neighbours of v at level k + 1 in their order, none where v is fixed; faces, beside
    it: the face of v, that neighbour and the next. parents (n, 2): ends of the edge that a vertex halves, -1 for the base.
    fixed (n,): vertices that do not move, those of the border; n (L + 1,): number of vertices of each level from the base
    on, which come first.
    """

    F: np.ndarray
    first: np.ndarray
    at: np.ndarray
    around: np.ndarray
    faces: np.ndarray
    parents: np.ndarray
    fixed: np.ndarray
    n: np.ndarray


@compiled(allocates=True)
def _collect(F, opposite, first, fixed, at, around, faces):
    """The rings of one level, whose faces are numbered from `first` on; at (n + 1,) starts with the first free place."""
    n = len(at) - 1
    out = np.full(n, -1, np.int64)
    for f in range(len(F)):
        for c in range(3):
            out[F[f, c]] = 3 * f + c
    end = at[0]
    for v in range(n):
        h = start = out[v]
        while h >= 0 and not fixed[v]:
            around[end], faces[end] = F[h // 3, (h + 1) % 3], h // 3 + first
            end += 1
            h = opposite[prev_halfedge(h)]
            if h == start:
                break
        at[v + 1] = end


def one_rings_of(levels: list[Level]) -> OneRings:
    """The rings of levels 1..L of a hierarchy (levels 0..L)."""
    n = np.array([level.n for level in levels])
    last = levels[-1]
    parents = np.full((last.n, 2), -1, np.int32)
    for level in levels[:-1]:
        parents[level.n:level.n + len(level.edges)] = level.edges
    fixed = np.zeros(last.n, bool)
    fixed[last.F.reshape(-1)[last.opposite == np.arange(last.F.size)]] = True
    levels = levels[1:]
    F = np.concatenate([level.F for level in levels])
    first = np.cumsum([0] + [len(level.F) for level in levels])
    at = np.zeros((len(levels), last.n + 1), np.int64)
    around, faces = np.empty(F.size, np.int32), np.empty(F.size, np.int32)
    for k, level in enumerate(levels):
        at[k, 0] = at[k - 1, -1] if k else 0
        _collect(level.F, level.opposite, first[k], fixed, at[k], around, faces)
    return OneRings(F, first, at, around, faces, parents, fixed, n)

