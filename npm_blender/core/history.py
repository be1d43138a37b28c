"""The record of collapses in flat arrays: which faces each one touched, and their planar positions before and after.

Collapse c has the entries first[c] .. first[c + 1] - 1, one per face before it: its `sides[c]` ring faces (present
before and after), then the one or two faces that vanish. Entry e: face[e] = 4 * face + corner of the owner;
collapse[e]; previous[e] and next[e]: the entry of the same face in an earlier and a later collapse, or -1.
The planar positions of collapse c are uv[at[c] :]: ring[c] ring vertices, then i, j, k (see halfedge for s1, s2).
head and tail (m,): last and first entry of each input face, or -1.
"""
from typing import NamedTuple

import numpy as np

_PER_COLLAPSE = ("first", "at", "ring", "sides", "s1", "s2")
_PER_ENTRY = ("face", "collapse", "previous", "next")


class History(NamedTuple):
    """See the module. first, at: int64; ring, sides, s1, s2: int16; the entries int32; uv complex128."""

    first: np.ndarray
    at: np.ndarray
    ring: np.ndarray
    sides: np.ndarray
    s1: np.ndarray
    s2: np.ndarray
    face: np.ndarray
    collapse: np.ndarray
    previous: np.ndarray
    next: np.ndarray
    uv: np.ndarray
    head: np.ndarray
    tail: np.ndarray

    @staticmethod
    def empty(faces: int) -> "History":
        """No collapses yet, for a mesh with that many faces."""
        wide, narrow, entry = np.zeros(1, np.int64), np.zeros(1, np.int16), np.zeros(1, np.int32)
        none = np.full(faces, -1, np.int32)
        fields = {"first": wide, "at": wide, "uv": np.zeros(1, np.complex128), "head": none, "tail": none}
        fields |= dict.fromkeys(_PER_COLLAPSE[2:], narrow) | dict.fromkeys(_PER_ENTRY, entry)
        return History(**{k: v.copy() for k, v in fields.items()})

    def _resized(self, collapses: int, entries: int, positions: int) -> "History":
        def fit(a: np.ndarray, n: int) -> np.ndarray:
            out = np.zeros(n, a.dtype)
            out[:min(n, len(a))] = a[:n]
            return out

        new = {k: fit(getattr(self, k), collapses + 1) for k in _PER_COLLAPSE}
        new |= {k: fit(getattr(self, k), entries) for k in _PER_ENTRY}
        return self._replace(uv=fit(self.uv, positions), **new)

    def with_room(self, counts: np.ndarray, collapses: int) -> "History":
        """Itself, or a copy with at least twice the room, so that about `collapses` more collapses fit.

        counts[2:5]: collapses, entries and positions in use.
        """
        used = [int(v) for v in counts[2:5]]
        room = [len(self.first) - 1, len(self.face), len(self.uv)]
        need = [u + k * collapses for u, k in zip(used, (1, 16, 16), strict=True)]
        if all(n <= r for n, r in zip(need, room, strict=True)):
            return self
        return self._resized(*(max(n, 3 * r // 2) if n > r else r for n, r in zip(need, room, strict=True)))

    def trimmed(self, counts: np.ndarray) -> "History":
        """A copy without unused room."""
        return self._resized(*(int(v) for v in counts[2:5]))
