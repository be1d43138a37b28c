r"""Half-edge adjacency of a triangle mesh, and what follows from it: borders, components, Euler characteristic.

Index conventions, binding for the whole core (this is the one place that states them):

               c               faces       f = (a, b, c), g = (b, a, d), counter-clockwise seen from outside
             /   \
     3f+2  /       \  3f+1     half-edge   h = 3 f + k runs from corner k of face f to its corner k + 1 (mod 3)
         /     f     \
       a  --- 3f+0 --> b       next        of 3 f + k is 3 f + (k + 1) % 3, prev 3 f + (k + 2) % 3: both stay in the face
       a  <-- 3g+0 --- b
         \     g     /         opposite    of 3 f is 3 g and of 3 g is 3 f: the half-edge on the other side of the edge
     3g+1  \       /  3g+2
             \   /             border      opposite(h) = h where no face lies on the other side
               d

So `opposite` is its own inverse everywhere, and gathers need no special case for the border. A corner has the number of the
half-edge that starts at it: F.reshape(-1)[h] is the vertex at the start of h. An edge is a pair of opposite half-edges, or one
half-edge on the border. Of compiled code, `geometry.halfedge_steps` does the same steps.
"""
from dataclasses import dataclass

import numpy as np

from ..errors import MeshError
from .components import component_labels, count_roots
from .radix_order import radix_argsort


def next_halfedges(h: np.ndarray) -> np.ndarray:
    """The next half-edge in the face of each half-edge of h, in h's shape and dtype: 3 f + k -> 3 f + (k + 1) % 3.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import next_halfedges
    >>> next_halfedges(np.arange(6)).tolist()
    [1, 2, 0, 4, 5, 3]
    """
    return h // 3 * 3 + (h + 1) % 3


def prev_halfedges(h: np.ndarray) -> np.ndarray:
    """The previous half-edge in the face of each half-edge of h, in h's shape and dtype: 3 f + k -> 3 f + (k + 2) % 3.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import prev_halfedges
    >>> F = np.array([[7, 8, 9]])
    >>> F.reshape(-1)[prev_halfedges(np.array([0]))].tolist()  # the corner opposite to the edge 7-8
    [9]
    """
    return h // 3 * 3 + (h + 2) % 3


def directed_edges(F: np.ndarray) -> np.ndarray:
    """Start and end vertex of every half-edge of faces F (m, 3), (3 m, 2) of F's dtype.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import directed_edges
    >>> directed_edges(np.array([[7, 8, 9]])).tolist()
    [[7, 8], [8, 9], [9, 7]]
    """
    return np.stack([F, np.roll(F, -1, 1)], 2).reshape(-1, 2)


def paired_halfedges(F: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Half-edges by edge: order (3 m,) sorted by (smaller, larger) vertex; first (3 m,) bool: whether an edge starts at that
    place of the order; opposite (3 m,) int32, itself on the border.

    Raises MeshError if an edge has more than two faces or two faces that run the same way.
    """
    start, end = directed_edges(F).T
    key = np.minimum(start, end).astype(np.int64) * (int(F.max()) + 1) + np.maximum(start, end)
    order = radix_argsort(key)
    ranked = key[order]
    pair = ranked[1:] == ranked[:-1]
    h, o = order[:-1][pair], order[1:][pair]
    if (start[h] == start[o]).any() or (pair[1:] & pair[:-1]).any():
        _, uses = np.unique(key * 2 + (start < end), return_counts=True)
        raise MeshError(f"Expected an oriented manifold, found {(uses - 1).sum()} edges used twice in one direction; "
                        "clean the mesh first (--clean auto)")
    opposite = np.arange(F.size, dtype=np.int32)
    opposite[h], opposite[o] = o, h
    return order, np.concatenate([[True], ~pair]), opposite


def opposite_halfedges(F: np.ndarray) -> np.ndarray:
    """Opposite half-edge of each of the 3 m half-edges of F (m, 3), (3 m,) int32; itself on the border.

    Raises MeshError if F is not an oriented edge-manifold, as `paired_halfedges` does.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import opposite_halfedges
    >>> opposite_halfedges(np.array([[0, 1, 2], [0, 2, 3]])).tolist()  # only 2 and 3 have faces on both sides
    [0, 1, 3, 2, 4, 5]
    """
    return paired_halfedges(F)[2]


def vertex_fans(F: np.ndarray, opposite: np.ndarray, n: int) -> np.ndarray:
    """Number of face fans round each vertex, (n,) int32: 0 unused, 1 manifold, more than 1 pinched.

    The corners of a vertex are joined across interior edges; the parts that remain are its fans.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import opposite_halfedges, vertex_fans
    >>> F = np.array([[0, 1, 2], [0, 3, 4]])  # two faces that meet in vertex 0 alone
    >>> vertex_fans(F, opposite_halfedges(F), 5).tolist()
    [2, 1, 1, 1, 1]
    """
    h = np.arange(F.size)
    inner = opposite != h
    # corner of the start of h, and the corner at the same vertex on the other side: the end of the opposite
    a, b = h[inner], next_halfedges(opposite)[inner]
    return count_roots(F.reshape(-1), a, b, n)


@dataclass(frozen=True)
class Topology:
    """Counts that a decimation must keep. components, border_loops, euler = V - E + F (used vertices only).

    >>> from npm_blender.core.mesh import Topology
    >>> torus = Topology(vertices=12, edges=36, faces=24, components=1, border_loops=0, border_edges=0)
    >>> torus.euler, torus.genus
    (0, 1.0)
    """

    vertices: int
    edges: int
    faces: int
    components: int
    border_loops: int
    border_edges: int

    @property
    def euler(self) -> int:
        """Euler characteristic V - E + F; 2 for a sphere, 2 - 2 g for closed genus g."""
        return self.vertices - self.edges + self.faces

    @property
    def genus(self) -> float:
        """Total genus of the components, (2 C - B - euler) / 2 with C components and B border loops."""
        return (2 * self.components - self.border_loops - self.euler) / 2


def topology_of(F: np.ndarray) -> Topology:
    """The topology of faces F (m, 3). Raises MeshError if F is not an oriented edge-manifold.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import topology_of
    >>> square = topology_of(np.array([[0, 1, 2], [0, 2, 3]]))
    >>> square.edges, square.border_loops, square.euler
    (5, 1, 1)
    """
    opposite = opposite_halfedges(F)
    h = np.arange(F.size)
    border = opposite == h
    n = int(F.max()) + 1
    parts = component_labels(len(F), h // 3, opposite // 3)
    start, end = directed_edges(F)[border].T
    loops = component_labels(n, start, end)
    return Topology(
        vertices=len(np.unique(F)), edges=int((F.size + border.sum()) // 2), faces=len(F),
        components=len(np.unique(parts)), border_loops=len(np.unique(loops[start])), border_edges=int(border.sum()))
