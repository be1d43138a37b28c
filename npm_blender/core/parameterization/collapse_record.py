"""The record of collapses in flat arrays: which faces each one touched, and their planar positions before and after.

Collapse c has the faces FIRST of c to FIRST of c + 1, those there were before it: its SIDES ring faces (present before and
after), then the one or two that vanish. Each is 4 * face + corner of the owner. The planar positions of collapse c are
uv[AT of c :]: RING ring vertices, then i, j, k (see halfedge for S1, S2). What a step of the map looks up together lies
together.
"""
from typing import NamedTuple

import numpy as np

from ..parallel import each

EACH = (1, 10, 11)  # collapses, faces and positions that a collapse takes in the mean, about
SPARE = 200  # of each that are always left: a collapse takes less (see halfedge.MAX_RING)
FIRST, AT, RING, SIDES, S1, S2 = range(6)  # columns of `collapses`


class CollapseRecord(NamedTuple):
    """See the module. collapses (c + 1, 6) int32, of whose last row only FIRST counts (the rest is 0); faces (e,) int32;
    uv (p,) complex128."""

    collapses: np.ndarray
    faces: np.ndarray
    uv: np.ndarray

    @staticmethod
    def empty() -> "CollapseRecord":
        """No collapses yet."""
        return CollapseRecord(np.zeros((1, 6), np.int32), np.zeros(0, np.int32), np.zeros(0, np.complex128))

    def with_room(self, counts: np.ndarray, collapses: int) -> "CollapseRecord":
        """Itself, or a copy with at least half as much room again, so that about `collapses` more collapses fit.

        At least one more does, of any size. counts[2:5]: collapses, faces and positions in use.
        """
        return self._grown(counts, counts[2:5], collapses)

    def _grown(self, counts: np.ndarray, taken: np.ndarray, collapses: int) -> "CollapseRecord":
        """Itself or a copy with room for `collapses` more than have taken (3,) collapses, faces and positions."""
        arrays = []
        used = counts[2] + 1, counts[3], counts[4]
        for array, filled, start, each_takes in zip(self, used, taken, EACH, strict=True):
            least = int(start) + each_takes * collapses + SPARE
            if len(array) < least:
                old, array = array, np.empty((max(least, 3 * len(array) // 2), *array.shape[1:]), array.dtype)
                array[:filled] = old[:filled]
            arrays.append(array)
        return CollapseRecord(*arrays)

    def used(self, counts: np.ndarray) -> "CollapseRecord":
        """Itself without unused room; views, not copies."""
        collapses, faces, positions = (int(v) for v in counts[2:5])
        self.collapses[collapses, 1:] = 0
        return CollapseRecord(self.collapses[:collapses + 1], self.faces[:faces], self.uv[:positions])

    def followed_by(self, counts: np.ndarray, parts: list["CollapseRecord"], collapses: int) -> "CollapseRecord":
        """Its collapses and then those of parts, with room for about `collapses` more; counts follow.

        No part touches a face of another; they have no unused room, and count from 0.
        """
        sizes = np.array([[len(h.collapses) - 1, len(h.faces), len(h.uv)] for h in parts], np.int64)
        ends = counts[2:5] + sizes.cumsum(0)
        joined = self._grown(counts, ends[-1], collapses)

        def append(k: int) -> None:
            part, (c, f, p), (c_end, f_end, p_end) = parts[k], ends[k] - sizes[k], ends[k]
            joined.collapses[c:c_end] = part.collapses[:-1]
            joined.collapses[c:c_end, FIRST] += f
            joined.collapses[c:c_end, AT] += p
            joined.faces[f:f_end], joined.uv[p:p_end] = part.faces, part.uv

        each(append, range(len(parts)))
        joined.collapses[ends[-1, 0], FIRST] = ends[-1, 1]
        counts[2:5] = ends[-1]
        return joined
