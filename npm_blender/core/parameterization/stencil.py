"""The stencil of an edge collapse, the faces round the edge that it changes, and the work space of their flattening.

Positions in the plane are complex numbers uv (ring_size + 3,): those of the ring, then of i, of j and of k, the vertex
that takes their place.
"""
from typing import NamedTuple

import numpy as np

from ..jit import compiled

INNER, ANCHORED, EDGE = 0, 1, 2  # kinds of stencils, see `Stencil`
MAX_RING = 96  # faces that both ends of an edge may have together, each counted at each end
SPARE = 8  # entries that arrays for a ring have besides: the faces that vanish, the positions of i, j and k


class Stencil(NamedTuple):
    """The faces round the edge from vertex i to vertex j, before both become one vertex in the place of i (ours).

    ring (>= ring_size,) int32: the vertices round the edge, counter-clockwise. Side q of the ring runs from vertex q to
    the next one and carries one face, of i or of j; `sides` of them: as many as vertices where the ring is closed, one less
    where it is open. Sides j_start to j_stop - 1 carry the faces of j, the others those of i. Two more faces lie on the edge
    and vanish: (i, j, ring[j_stop]) and (j, i, ring[j_start]).
    faces (>= sides + 2,) int32: the face of each side, then those that vanish, as 4 * face + corner, the corner being that
    of i or j; of the faces that vanish, that of i in the first and of j in the second.
    kind: INNER where both ends lie inside the mesh (closed ring, j_start = 0), ANCHORED where i lies on the border (open ring),
    EDGE where the edge itself does (open ring, j_start = 0, and only the first of the two faces on the edge).

    >>> import numpy as np
    >>> from npm_blender.core.parameterization import INNER, Stencil
    >>> ring = np.array([2, 3, 4, 5], np.int32)  # j = 1 has the faces on the sides 2-3 and 3-4, i = 0 those on 4-5 and 5-2
    >>> stencil = Stencil(INNER, ring, np.zeros(6, np.int32), ring_size=4, sides=4, j_start=0, j_stop=2, i=0, j=1)
    >>> [(0, 1, int(ring[stencil.j_stop])), (1, 0, int(ring[stencil.j_start]))]  # these vanish
    [(0, 1, 4), (1, 0, 2)]
    """

    kind: int
    ring: np.ndarray
    faces: np.ndarray
    ring_size: int
    sides: int
    j_start: int
    j_stop: int
    i: int
    j: int


class Workspace(NamedTuple):
    """Arrays that the flattening of a stencil works in, and its result; made once for many collapses (ours).

    uv complex128: the positions, see the module; cotangents (., 3) float64: of the triangles' angles (see `lscm.measure`);
    ring_system (., 6) complex128: the equations of the ring vertices (see `lscm.assemble`); end_system (3, 4) complex128:
    what is left of them, for the first and last ring vertex and k; real_system (6, 7) float64: the same in real numbers.

    >>> from npm_blender.core.parameterization import MAX_RING, Workspace
    >>> len(Workspace.make().uv) >= MAX_RING + 3
    True
    """

    uv: np.ndarray
    cotangents: np.ndarray
    ring_system: np.ndarray
    end_system: np.ndarray
    real_system: np.ndarray

    @staticmethod
    def make() -> "Workspace":
        """Work space for rings of up to MAX_RING vertices."""
        n = MAX_RING + SPARE
        return Workspace(np.zeros(n, np.complex128), np.zeros((2 * n, 3)), np.zeros((n, 6), np.complex128),
                         np.zeros((3, 4), np.complex128), np.zeros((6, 7)))


@compiled(inline="always")
def next_on_ring(stencil, q):
    """The number of the ring vertex after number q; on an open ring, too, 0 after the last (ours).

    >>> import numpy as np
    >>> from npm_blender.core.parameterization import INNER, Stencil, next_on_ring
    >>> stencil = Stencil(INNER, np.zeros(4, np.int32), np.zeros(6, np.int32), 4, 4, 0, 2, 0, 1)
    >>> [int(next_on_ring(stencil, q)) for q in range(4)]
    [1, 2, 3, 0]
    """
    return q + 1 if q + 1 < stencil.ring_size else 0


@compiled(inline="always")
def is_of_j(stencil, q):
    """Whether the face on side q of the ring is one of j, not of i (ours).

    >>> import numpy as np
    >>> from npm_blender.core.parameterization import INNER, Stencil, is_of_j
    >>> stencil = Stencil(INNER, np.zeros(4, np.int32), np.zeros(6, np.int32), 4, 4, 0, 2, 0, 1)
    >>> [bool(is_of_j(stencil, q)) for q in range(4)]
    [True, True, False, False]
    """
    return stencil.j_start <= q < stencil.j_stop


@compiled(inline="always")
def third_vertex(stencil):
    """The number of the ring vertex opposite to i -> j in the first of the faces that vanish."""
    return stencil.j_stop if stencil.j_stop < stencil.ring_size else 0
