"""A level's connectivity as index arrays of a backend."""
from dataclasses import dataclass

import numpy as np

from ..mesh import Level
from .backend import Array, Backend, Index


@dataclass(frozen=True)
class MeshIndex:
    """A level's connectivity as index arrays of a backend; half-edges are numbered as in `mesh.topology`.

    m faces, n vertices. F (3 m,) corner vertices, which half-edges start at; opposite (3 m,); end (3 m,) where they end;
    edge_a, edge_b (e,) ends of each edge; left, right (e,) the half-edges of each edge (equal on the border); inner (3 m, 1)
    float: 0 on the border, else 1; share (n, 1) float: 1 / number of corners at a vertex; edge_of (3 m,): edge of each
    half-edge; side (3 m, 1) float: 1 if it is the edge's left half-edge, else -1.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import Level
    >>> from npm_blender.core.network import NUMPY, MeshIndex
    >>> mesh = MeshIndex.of(NUMPY, Level.of(np.array([[0, 1, 2], [0, 2, 3]]), 4))  # a square cut along 0-2
    >>> list(zip(mesh.edge_a.tolist(), mesh.edge_b.tolist()))
    [(0, 1), (0, 2), (0, 3), (1, 2), (2, 3)]
    >>> mesh.opposite.tolist(), mesh.inner[:, 0].tolist()
    ([0, 1, 3, 2, 4, 5], [0.0, 0.0, 1.0, 1.0, 0.0, 0.0])
    """

    m: int
    n: int
    F: Index
    opposite: Index
    end: Index
    edge_a: Index
    edge_b: Index
    left: Index
    right: Index
    inner: Array
    share: Array
    edge_of: Index
    side: Array

    @staticmethod
    def of(B: Backend, level: Level) -> "MeshIndex":
        """The index arrays of one level."""
        m = len(level.F)
        end = level.F[:, [1, 2, 0]].reshape(-1)
        halfedge = np.arange(3 * m)
        inner = (level.opposite != halfedge).astype(np.float32)[:, None]
        share = 1 / np.maximum(np.bincount(level.F.reshape(-1), minlength=level.n), 1)[:, None]
        side = np.where(level.edge_halfedge[level.edge_of, 0] == halfedge, 1, -1).astype(np.float32)[:, None]
        return MeshIndex(m, level.n, B.index(level.F.reshape(-1)), B.index(level.opposite), B.index(end),
                         B.index(level.edges[:, 0]), B.index(level.edges[:, 1]), B.index(level.edge_halfedge[:, 0]),
                         B.index(level.edge_halfedge[:, 1]), B.array(inner), B.array(share), B.index(level.edge_of),
                         B.array(side))
