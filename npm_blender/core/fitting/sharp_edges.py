"""Which edges of a base are creases, and which of their vertices are corners: by the angles of its faces and edges."""
import numpy as np

from ..mesh import Level, Sharp, TriMesh, turns

TURN = 50.0  # degrees that a border or a line of creases turns by in a corner


def sharp_of(V0: np.ndarray, base: Level, angle: float) -> Sharp:
    """Edges of a base whose faces meet at more than `angle` degrees, and corners of borders and of lines of such edges.

    V0 (n0, 3): positions. A crease by its angle, as in Hoppe et al. 1994 before their optimization.

    >>> import numpy as np
    >>> from npm_blender.core.fitting import sharp_of
    >>> from npm_blender.core.mesh import Level
    >>> roof = np.array([[0.0, -1, 0], [0, 1, 0], [1, 0, -1], [-1, 0, -1]])
    >>> found = sharp_of(roof, Level.of(np.array([[0, 2, 1], [0, 1, 3]]), 4), angle=40)
    >>> found.edges.sum().tolist(), found.corners.tolist()  # the ridge, and where the border turns
    (1, [False, False, True, True])
    """
    normals = TriMesh(V0, base.F).face_normals()
    left, right = base.edge_halfedge.T.astype(np.int64)
    border = left == right
    cosine = (normals[left // 3] * normals[right // 3]).sum(1)
    edges = ~border & (cosine < np.cos(np.radians(angle)))
    ends = base.edges[edges | border]
    corner = turns(V0, ends) > (2 * np.sin(np.radians(TURN / 2))) ** 2
    return Sharp(edges, (np.bincount(ends.reshape(-1), minlength=base.n) == 2) & corner)
