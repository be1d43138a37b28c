"""A renumbering of a base mesh, the one that its receiver will see."""
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Renumbering:
    """A renumbering of the base mesh, the one in which the receiver will see it (see `connectivity.canonical_order`).

    vertices (n0,) int32: old index of each new vertex; faces (m0,) int32: old index of each new face;
    F (m0, 3) int32: the new faces in the new numbering. Corners may be rotated against the old face, never mirrored.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import Renumbering
    >>> old = np.array([[5, 3, 8]])
    >>> new = Renumbering(vertices=np.array([8, 5, 3]), faces=np.array([0]), F=np.array([[0, 1, 2]]))
    >>> new.vertices[new.F].tolist()  # the old face, from another corner on
    [[8, 5, 3]]
    """

    vertices: np.ndarray
    faces: np.ndarray
    F: np.ndarray
