"""Which edges and vertices of a mesh stay sharp when it is subdivided."""
from typing import NamedTuple

import numpy as np

from .radix_order import radix_argsort
from .subdivision import Level


class Sharp(NamedTuple):
    """edges (e,) bool: the edges of a level that are creases; corners (n,) bool: vertices in which a border or a line of creases
    turns. Tagged edges as in Hoppe, DeRose, Duchamp, Halstead, Jin, McDonald, Schweitzer, Stuetzle 1994.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import Level, Sharp
    >>> triangle = Level.of(np.array([[0, 1, 2]]), 3)
    >>> Sharp(np.array([True, False, False]), np.zeros(3, bool)).subdivided(triangle).edges.sum().tolist()  # both its halves
    2
    """

    edges: np.ndarray
    corners: np.ndarray

    def subdivided(self, level: Level) -> "Sharp":
        """The same at the next level; level: the one that they are of."""
        halves = radix_argsort(level.edges.reshape(-1))  # in this order the next level has the halves of edges, and then others
        others = np.zeros(level.F.size, bool)
        return Sharp(np.concatenate([self.edges[halves // 2], others]), np.concatenate([self.corners, others[:len(level.edges)]]))

    def lines(self, level: Level) -> np.ndarray:
        """Edges (e,) bool along which a surface over the level has two sides: the creases and the border."""
        return self.edges | (level.edge_halfedge[:, 0] == level.edge_halfedge[:, 1])


def turns(V: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Squared length (n,) of the sum of the unit vectors along the edges that leave each vertex of V (n, 3).

    edges (k, 2): of lines. 0 where a line goes straight on, 4 sin(a / 2)^2 where it turns by the angle a.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import turns
    >>> turns(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0]]), np.array([[0, 1], [1, 2]])).tolist()
    [1.0, 2.0, 1.0]
    """
    along = (V[edges[:, 1]] - V[edges[:, 0]]).astype(np.float64)
    along /= np.maximum(np.sqrt(along[:, :1] ** 2 + along[:, 1:2] ** 2 + along[:, 2:] ** 2), 1e-300)
    leaving, place = np.concatenate([along, -along]), edges.T.reshape(-1)
    total = np.stack([np.bincount(place, axis, len(V)) for axis in leaving.T], 1)
    return total[:, 0] ** 2 + total[:, 1] ** 2 + total[:, 2] ** 2
