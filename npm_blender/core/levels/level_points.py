"""Where the map puts the vertices and edge midpoints of a subdivided base: points of the input surface."""
import numpy as np

from ..decimation import Decimation
from ..jit import compiled
from ..mesh import Level, radix_argsort
from ..parallel import each, threads
from ..progress import Progress, no_progress

MESSAGE = "Mapping the levels"
FEWEST, MOST = 6_000, 26_000  # points that a thread maps between two calls of `progress`


def level_corners(level_count: int) -> np.ndarray:
    """Barycentric corners (4^level_count, 3, 3) of the faces that one face splits into, in the order of `hierarchy`."""
    out = np.eye(3)[None]
    for _ in range(level_count):
        a, b, c = out.swapaxes(0, 1)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        children = ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))
        out = np.stack([np.stack(t, 1) for t in children], 1).reshape(-1, 3, 3)
    return out


def halfedges_with(level: Level) -> np.ndarray:
    """A half-edge that starts at each vertex of a level, then one that runs along each edge, (n + e,) int64."""
    ids = level.F.reshape(-1)
    owner = np.zeros(level.n, np.int64)
    owner[ids[::-1]] = np.arange(len(ids))[::-1]
    return np.concatenate([owner, level.edge_halfedge[:, 0]])


@compiled
def _start(halfedge, n, order, first, last, corners, old_face, rotation, face, b):
    """Base face and barycentrics of points order[first:last] of a level, in face and b (last - first, 3); see `map_points`."""
    children = len(corners)
    for k in range(first, last):
        h = halfedge[order[k]]
        f, child, c = h // (3 * children), h // 3 % children, h % 3
        d = c + 1 if c < 2 else 0
        face[k - first] = old_face[f]
        for s in range(3):  # corner s of a face is corner rotation + s of the old one
            x = corners[child, c, s]
            b[k - first, (rotation[f] + s) % 3] = (x + corners[child, d, s]) / 2 if order[k] >= n else x


@compiled
def _put(order, first, last, face, b, out, out_b):
    """Put face and b of points order[first:last] at their places in out and out_b."""
    for k in range(first, last):
        out[order[k]] = face[k - first]
        for s in range(3):
            out_b[order[k], s] = b[k - first, s]


def map_points(decimation: Decimation, level: Level, corners: np.ndarray, old_face: np.ndarray, rotation: np.ndarray,
               progress: Progress = no_progress) -> tuple[np.ndarray, np.ndarray]:
    """Where the map puts the vertices and edge midpoints of a level: input face (n + e,) and barycentric (n + e, 3).

    corners: `level_corners`; old_face, rotation (m0,): the base face of the decimation that each face of level 0 is, and
    the corner of it that comes first here. Neighbours are mapped one after the other, through the same collapses.
    """
    halfedge = halfedges_with(level)
    order = radix_argsort(halfedge)
    face, b = np.empty(len(order), np.int32), np.empty((len(order), 3))
    size = min(max(-(-len(order) // threads()), FEWEST), MOST)

    surface_map = decimation.surface_map

    def task(first: int) -> None:
        last = min(first + size, len(order))
        at, at_b = np.empty(last - first, np.int32), np.empty((last - first, 3))
        _start(halfedge, level.n, order, first, last, corners, old_face, rotation, at, at_b)
        at, at_b = surface_map.coarse_to_fine(at, at_b)
        _put(order, first, last, at, at_b, face, b)

    each(task, range(0, len(order), size), progress, MESSAGE)
    return face, b
