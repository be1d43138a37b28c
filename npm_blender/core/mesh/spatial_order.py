"""The order of a mesh in memory: what is near on the surface is near in memory, so that loops over it find it cached."""
import numpy as np

from .radix_order import radix_argsort
from .triangle_mesh import TriMesh

BITS = 10  # of a coordinate on the grid
GRID = 2**BITS  # cells per axis


def morton_keys(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Place (n,) uint32 along Morton's curve (1966) of grid cells x, y, z (n,) uint32, each below GRID.

    Bit i of x becomes bit 3 i of the key, that of y bit 3 i + 1, that of z bit 3 i + 2.
    """

    def spread(x: np.ndarray) -> np.ndarray:  # two zeros between each bit and the next
        for shift, mask in ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249)):
            x = (x | (x << np.uint32(shift))) & np.uint32(mask)
        return x

    return spread(x) | (spread(y) << np.uint32(1)) | (spread(z) << np.uint32(2))


def in_morton_order(mesh: TriMesh) -> TriMesh:
    """The same mesh, its vertices along a Morton curve and its faces by their first vertex; corners keep their order.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import TriMesh, in_morton_order
    >>> mesh = TriMesh.from_arrays([[1.0, 1, 0], [0, 0, 0], [1, 0, 0], [0, 1, 0]], [[1, 2, 0], [1, 0, 3]])
    >>> ordered = in_morton_order(mesh)
    >>> ordered.V[:, :2].tolist(), ordered.F.tolist()  # along a Z: both lower corners, then both upper ones
    ([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]], [[0, 1, 3], [0, 3, 2]])
    """
    if len(mesh.V) == 0:
        return mesh
    columns = np.ascontiguousarray(mesh.V.T)  # numpy takes an extremum of a row, not of a column, at full speed
    low = columns.min(1)
    extent = max(float((columns.max(1) - low).max()), 1e-300)
    order = radix_argsort(morton_keys(*((columns - low[:, None]) / extent * (GRID - 1)).astype(np.uint32)))
    place = np.empty(len(order), np.int32)
    place[order] = np.arange(len(order), dtype=np.int32)
    F = place.take(mesh.F)  # numpy takes rows several times faster by `take` than by an index
    return TriMesh(mesh.V.take(order, 0), F.take(radix_argsort(np.minimum(np.minimum(F[:, 0], F[:, 1]), F[:, 2])), 0))


def spatial_boxes(P: np.ndarray, most: int) -> np.ndarray:
    """Points P (n, 3) divided into boxes of at most `most` points, by halves along the longest side: box (n,) int32.

    Bentley's k-d tree (1975), of which only the leaves are kept.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import spatial_boxes
    >>> spatial_boxes(np.array([[0.0, 0, 0], [5, 0, 0], [1, 0, 0], [6, 0, 0]]), most=2).tolist()
    [0, 1, 0, 1]
    """
    out = np.zeros(len(P), np.int32)
    groups, found = [(np.arange(len(P)), np.ascontiguousarray(P.T))], 0
    while groups:
        group, columns = groups.pop()
        if len(group) <= most:
            out[group] = found
            found += 1
            continue
        side = (columns.max(1) - columns.min(1)).argmax()
        order = np.argpartition(columns[side], len(group) // 2)
        for half in (order[len(group) // 2:], order[:len(group) // 2]):
            groups.append((group[half], columns.take(half, 1)))
    return out


def along_curve(P: np.ndarray) -> np.ndarray:
    """Order of P (n, 3) along Morton's curve (see `morton_keys`) through its bounding box, (n,) int64.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import along_curve
    >>> along_curve(np.array([[9.0, 0, 0], [0, 0, 0], [8, 0, 0], [1, 0, 0]])).tolist()
    [1, 3, 2, 0]
    """
    if len(P) == 0:
        return np.zeros(0, np.int64)
    low = P.min(0)
    size = max(float((P.max(0) - low).max()), 1e-300)
    return radix_argsort(morton_keys(*np.minimum((P - low) * (GRID / size), GRID - 1).astype(np.uint32).T))
