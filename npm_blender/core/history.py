"""The record of collapses in flat arrays: which faces each one touched, and their planar positions before and after.

Collapse c has the entries FIRST of c to FIRST of c + 1, one per face before it: its SIDES ring faces (present before and
after), then the one or two faces that vanish. An entry: FACE, 4 * face + corner of the owner; COLLAPSE; PREVIOUS and
NEXT, the entry of the same face in an earlier and a later collapse, or -1. The planar positions of collapse c are uv[AT
of c :]: RING ring vertices, then i, j, k (see halfedge for S1, S2). head and tail: last and first entry of each input
face, or -1. What a step of the map looks up together lies together.
"""
from typing import NamedTuple

import numpy as np

FIRST, AT, RING, SIDES, S1, S2 = range(6)  # columns of `collapses`
FACE, COLLAPSE, PREVIOUS, NEXT = range(4)  # columns of `entries`


class History(NamedTuple):
    """See the module. collapses (c + 1, 6) int32, of whose last row only FIRST counts; entries (e, 4) int32; uv (p,)
    complex128; head, tail (m,) int32."""

    collapses: np.ndarray
    entries: np.ndarray
    uv: np.ndarray
    head: np.ndarray
    tail: np.ndarray

    @staticmethod
    def empty(faces: int) -> "History":
        """No collapses yet, for a mesh with that many faces."""
        none = np.full(faces, -1, np.int32)
        return History(np.zeros((1, 6), np.int32), np.zeros((0, 4), np.int32), np.zeros(0, np.complex128), none, none.copy())

    def _resized(self, *rows: int) -> "History":
        def fit(a: np.ndarray, n: int) -> np.ndarray:
            out = np.zeros((n, *a.shape[1:]), a.dtype)
            out[:min(n, len(a))] = a[:n]
            return out

        return History(*map(fit, self[:3], rows), self.head, self.tail)

    def with_room(self, counts: np.ndarray, collapses: int) -> "History":
        """Itself, or a copy with at least half as much room again, so that about `collapses` more collapses fit.

        counts[2:5]: collapses, entries and positions in use.
        """
        need = [int(v) + k * collapses + 1 for v, k in zip(counts[2:5], (1, 16, 16), strict=True)]
        room = [len(a) for a in self[:3]]
        if all(n <= r for n, r in zip(need, room, strict=True)):
            return self
        return self._resized(*(max(n, 3 * r // 2) if n > r else r for n, r in zip(need, room, strict=True)))

    def used(self, counts: np.ndarray) -> "History":
        """Itself without unused room; views, not copies."""
        collapses, entries, positions = (int(v) for v in counts[2:5])
        return self._replace(collapses=self.collapses[:collapses + 1], entries=self.entries[:entries], uv=self.uv[:positions])

    def trimmed(self, counts: np.ndarray) -> "History":
        """A copy without unused room."""
        collapses, entries, positions = (int(v) for v in counts[2:5])
        return self._resized(collapses + 1, entries, positions)

    def followed_by(self, parts: list["History"]) -> "History":
        """Its collapses and then those of parts, none of which touches a face of another; all without unused room.

        The parts number their entries and collapses from 0; their head and tail do not count. Its own are changed.
        """
        chain = [self, *parts]
        collapses = np.concatenate([h.collapses[:-1] for h in chain] + [parts[-1].collapses[-1:]])
        entries = np.concatenate([h.entries for h in chain])
        c, e, p = len(self.collapses) - 1, len(self.entries), len(self.uv)
        for h in parts:
            rows = slice(c, c + len(h.collapses))
            collapses[rows, FIRST] = h.collapses[:, FIRST] + e
            collapses[rows, AT] = h.collapses[:, AT] + p
            of = entries[e:e + len(h.entries)]
            of[:, COLLAPSE] += c
            for column in (PREVIOUS, NEXT):
                of[:, column] += np.where(of[:, column] >= 0, e, 0).astype(np.int32)
            c, e, p = c + len(h.collapses) - 1, e + len(h.entries), p + len(h.uv)
        old = len(self.entries)
        opening, closing = (np.flatnonzero(entries[old:, column] < 0) + old for column in (PREVIOUS, NEXT))
        last = self.head[entries[opening, FACE] >> 2]
        entries[opening, PREVIOUS] = last
        entries[last[last >= 0], NEXT] = opening[last >= 0]
        self.tail[entries[opening[last < 0], FACE] >> 2] = opening[last < 0]
        self.head[entries[closing, FACE] >> 2] = closing
        return self._replace(collapses=collapses, entries=entries, uv=np.concatenate([h.uv for h in chain]))
