"""The record of collapses in flat arrays: which faces each one touched, and their planar positions before and after.

What a step of the map looks up together lies together.
"""
from typing import NamedTuple

import numpy as np

from ..parallel import each

EACH = (1, 10, 11)  # collapses, faces and positions that a collapse takes in the mean, about
ALWAYS_FREE = 200  # of each that are always left: a collapse takes less (see stencil.MAX_RING)
FIRST, AT, RING, SIDES, J_START, J_STOP = range(6)  # columns of `CollapseRecord.collapses`
COLLAPSES, FACES, POSITIONS = range(3)  # entries of `CollapseRecord.filled`


class CollapseRecord(NamedTuple):
    """Collapses, first to last, each with its stencil as face numbers and planar positions (ours).

    collapses (c + 1, 6) int32: a row for each collapse, and one whose FIRST alone counts (the rest is 0), with the columns

    | FIRST, AT        | where its faces begin in `faces` and its positions in `uv`; its faces end at FIRST of the next row |
    | RING, SIDES      | ring_size and sides of its `Stencil` |
    | J_START, J_STOP  | j_start and j_stop of its `Stencil` |

    faces (e,) int32: the faces that there were before it, as in `Stencil.faces`: those of its sides, which there are
    before and after, then the one or two that vanish. uv (p,) complex128: positions of its ring, then of i, j and k.
    filled (3,) int64: how many COLLAPSES, FACES and POSITIONS there are; the arrays may be longer (see `with_room`).

    >>> from npm_blender.core.decimation import decimate
    >>> from npm_blender.core.mesh import TriMesh
    >>> from npm_blender.core.parameterization import FIRST, SIDES, CollapseRecord
    >>> octahedron = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    >>> V = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    >>> record = decimate(TriMesh.from_arrays(V, octahedron), 6).record
    >>> record.collapses[:, [FIRST, SIDES]].tolist()  # one collapse: it deformed four faces, and two of its six vanished
    [[0, 4], [6, 0]]
    >>> CollapseRecord.empty().collapses.tolist()
    [[0, 0, 0, 0, 0, 0]]
    """

    collapses: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    filled: np.ndarray

    @staticmethod
    def empty() -> "CollapseRecord":
        """No collapses yet."""
        return CollapseRecord(np.zeros((1, 6), np.int32), np.zeros(0, np.int32), np.zeros(0, np.complex128),
                              np.zeros(3, np.int64))

    def with_room(self, collapses: int) -> "CollapseRecord":
        """Itself, or a copy with at least half as much room again, so that about `collapses` more collapses fit.

        At least one more does, of any size.
        """
        return self._grown(self.filled, collapses)

    def _grown(self, taken: np.ndarray, collapses: int) -> "CollapseRecord":
        """Itself or a copy with room for `collapses` more than have taken (3,) collapses, faces and positions."""
        arrays = []
        used = self.filled[COLLAPSES] + 1, self.filled[FACES], self.filled[POSITIONS]
        for array, filled, start, each_takes in zip(self[:3], used, taken, EACH, strict=True):
            least = int(start) + each_takes * collapses + ALWAYS_FREE
            if len(array) < least:
                old, array = array, np.empty((max(least, 3 * len(array) // 2), *array.shape[1:]), array.dtype)
                array[:filled] = old[:filled]
            arrays.append(array)
        return CollapseRecord._make([*arrays, self.filled])

    def used(self) -> "CollapseRecord":
        """Itself without unused room; views, not copies."""
        collapses, faces, positions = (int(v) for v in self.filled)
        self.collapses[collapses, 1:] = 0
        return CollapseRecord(self.collapses[:collapses + 1], self.faces[:faces], self.uv[:positions], self.filled)

    def followed_by(self, parts: list["CollapseRecord"], collapses: int) -> "CollapseRecord":
        """Its collapses and then those of parts, with room for about `collapses` more.

        No part touches a face of another; they have no unused room, and count from 0. Not to be used itself afterwards: its
        arrays are those of the result where they had room.
        """
        ends = self.filled + np.array([part.filled for part in parts]).cumsum(0)
        joined = self._grown(ends[-1], collapses)

        def append(k: int) -> None:
            part, (c_end, f_end, p_end) = parts[k], ends[k]
            c, f, p = ends[k] - part.filled
            joined.collapses[c:c_end] = part.collapses[:-1]
            joined.collapses[c:c_end, FIRST] += f
            joined.collapses[c:c_end, AT] += p
            joined.faces[f:f_end], joined.uv[p:p_end] = part.faces, part.uv

        each(append, range(len(parts)))
        joined.collapses[ends[-1, COLLAPSES], FIRST] = ends[-1, FACES]
        return joined._replace(filled=ends[-1])
