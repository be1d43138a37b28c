"""The record of collapses in flat arrays: which faces each one touched, and their planar positions before and after.

Collapse c has the entries FIRST of c to FIRST of c + 1, one per face before it: its SIDES ring faces (present before and
after), then the one or two faces that vanish. An entry: FACE, 4 * face + corner of the owner; COLLAPSE; NEXT, the
entry of the same face in a later collapse, or -1. The planar positions of collapse c are uv[AT
of c :]: RING ring vertices, then i, j, k (see halfedge for S1, S2). head and tail: last and first entry of each input
face, or -1. What a step of the map looks up together lies together.
"""
from typing import NamedTuple

import numpy as np

from .jit import compiled
from .parallel import each

EACH = (1, 10, 11)  # collapses, entries and positions that a collapse takes in the mean, about
SPARE = 200  # of each that are always left: a collapse takes less (see halfedge.MAX_RING)
FIRST, AT, RING, SIDES, S1, S2 = range(6)  # columns of `collapses`
FACE, COLLAPSE, NEXT = range(3)  # columns of `entries`


class History(NamedTuple):
    """See the module. collapses (c + 1, 6) int32, of whose last row only FIRST counts (the rest is 0); entries (e, 3) int32;
    uv (p,) complex128; head, tail (m,) int32."""

    collapses: np.ndarray
    entries: np.ndarray
    uv: np.ndarray
    head: np.ndarray
    tail: np.ndarray

    @staticmethod
    def empty(faces: int) -> "History":
        """No collapses yet, for a mesh with that many faces."""
        none = np.full(faces, -1, np.int32)
        return History(np.zeros((1, 6), np.int32), np.zeros((0, 3), np.int32), np.zeros(0, np.complex128), none, none.copy())

    def with_room(self, counts: np.ndarray, collapses: int) -> "History":
        """Itself, or a copy with at least half as much room again, so that about `collapses` more collapses fit.

        At least one more does, of any size. counts[2:5]: collapses, entries and positions in use.
        """
        return self._grown(counts, counts[2:5], collapses)

    def _grown(self, counts: np.ndarray, taken: np.ndarray, collapses: int) -> "History":
        """Itself or a copy with room for `collapses` more than have taken (3,) collapses, entries and positions."""
        arrays = []
        used = counts[2] + 1, counts[3], counts[4]
        for array, filled, start, each_takes in zip(self[:3], used, taken, EACH, strict=True):
            least = int(start) + each_takes * collapses + SPARE
            if len(array) < least:
                old, array = array, np.empty((max(least, 3 * len(array) // 2), *array.shape[1:]), array.dtype)
                array[:filled] = old[:filled]
            arrays.append(array)
        return self._replace(collapses=arrays[0], entries=arrays[1], uv=arrays[2])

    def used(self, counts: np.ndarray) -> "History":
        """Itself without unused room; views, not copies."""
        collapses, entries, positions = (int(v) for v in counts[2:5])
        self.collapses[collapses, 1:] = 0
        return self._replace(collapses=self.collapses[:collapses + 1], entries=self.entries[:entries], uv=self.uv[:positions])

    def followed_by(self, counts: np.ndarray, parts: list["History"], collapses: int) -> "History":
        """Its collapses and then those of parts, with room for about `collapses` more; counts follow.

        No part touches a face of another; they have no unused room, number their entries and collapses from 0, and their
        head does not count. Its own head and tail are changed.
        """
        sizes = np.array([[len(h.collapses) - 1, len(h.entries), len(h.uv)] for h in parts], np.int64)
        ends = counts[2:5] + sizes.cumsum(0)
        joined = self._grown(counts, ends[-1], collapses)
        each(lambda k: _append(joined, parts[k], *(ends[k] - sizes[k])), range(len(parts)))
        joined.collapses[ends[-1, 0], FIRST] = ends[-1, 1]
        counts[2:5] = ends[-1]
        return joined


@compiled
def _append(hist, part, c, e, p):
    """Copy a part's collapses into hist, as collapses c.., entries e.. and positions p.., behind what its faces have."""
    for k in range(len(part.collapses) - 1):
        for column in range(6):
            hist.collapses[c + k, column] = part.collapses[k, column]
        hist.collapses[c + k, FIRST] += e
        hist.collapses[c + k, AT] += p
    for k in range(len(part.entries)):
        f, after = part.entries[k, FACE] >> 2, part.entries[k, NEXT]
        if part.tail[f] == k:
            before = hist.head[f]
            if before >= 0:
                hist.entries[before, NEXT] = e + k
            else:
                hist.tail[f] = e + k
        if after >= 0:
            after += e
        else:
            hist.head[f] = e + k
        hist.entries[e + k, FACE], hist.entries[e + k, COLLAPSE] = part.entries[k, FACE], part.entries[k, COLLAPSE] + c
        hist.entries[e + k, NEXT] = after
    for k in range(len(part.uv)):
        hist.uv[p + k] = part.uv[k]
