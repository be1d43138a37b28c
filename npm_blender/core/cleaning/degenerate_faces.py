"""Faces without area: found, and mended so that no hole opens.

Edges of zero length are collapsed in any triangles at all. What is flat after that, inside a manifold, has the edge that it
folds over flipped.
"""
import numpy as np

from ..geometry import next_halfedge, prev_halfedge
from ..jit import compiled
from ..mesh import next_halfedges
from .edge_groups import EdgeGroups, vertex_parts

FLAT = 1e-10  # twice the area over the squared longest edge, below which a face counts as having no area
ROUNDS = 20  # over all faces, of flips at most


@compiled(allocates=True)
def flatness(V, F):
    """Twice the area over the squared longest edge of each face, (m,) float64; 0 for faces without extent."""
    out = np.zeros(len(F))
    for f in range(len(F)):
        i, j, k = F[f, 0], F[f, 1], F[f, 2]
        ax, ay, az = V[j, 0] - V[i, 0], V[j, 1] - V[i, 1], V[j, 2] - V[i, 2]
        bx, by, bz = V[k, 0] - V[i, 0], V[k, 1] - V[i, 1], V[k, 2] - V[i, 2]
        x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        longest = max(ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz,
                      (ax - bx) ** 2 + (ay - by) ** 2 + (az - bz) ** 2)
        if longest > 0:
            out[f] = np.sqrt(x * x + y * y + z * z) / longest
    return out


def repeated_corners(F: np.ndarray) -> np.ndarray:
    """(m,) bool: faces that name a vertex twice."""
    return (F[:, 0] == F[:, 1]) | (F[:, 1] == F[:, 2]) | (F[:, 2] == F[:, 0])


def collapse_zero_edges(V: np.ndarray, groups: EdgeGroups) -> tuple[np.ndarray, int]:
    """Faces with the ends of every edge of zero length made one vertex, and the number of vertices that went."""
    F, flat, first = groups.F, groups.F.reshape(-1), groups.halfedges[groups.starts[:-1]]
    start, end = flat[first], flat[next_halfedges(first)]
    zero = (V[start, 0] == V[end, 0]) & (start != end)
    zero[zero] = (V[start[zero]] == V[end[zero]]).all(1)
    if not zero.any():
        return F, 0
    part = vertex_parts(len(V), start[zero], end[zero])
    return part[F], int((part != np.arange(len(V))).sum())


def remove_flat_faces(V: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, int, int]:
    """F (m', 3) with fewer faces without area; how many were mended; and how many remain because nothing legal helps.

    F must be an oriented manifold without edges of zero length. A face whose three vertices lie on a line has its
    longest edge flipped with the neighbour, which splits the neighbour at the middle vertex; on the border the face is
    dropped (the result may then be pinched at a vertex).
    """
    groups = EdgeGroups.of(F, len(V))
    opposite = np.arange(F.size, dtype=np.int32)
    first = groups.starts[:-1][groups.sizes == 2]
    one, two = groups.halfedges[first], groups.halfedges[first + 1]
    opposite[one], opposite[two] = two, one
    F = np.ascontiguousarray(F, np.int32).copy()
    before, dropped, after = _flip(V, F.reshape(-1), opposite)
    return F[~dropped], int(before - after), int(after)


@compiled
def _square(V, i, j):
    """The squared distance of vertices i and j."""
    return (V[i, 0] - V[j, 0]) ** 2 + (V[i, 1] - V[j, 1]) ** 2 + (V[i, 2] - V[j, 2]) ** 2


@compiled
def _is_flat(V, i, j, k):
    """`flatness` of one face against FLAT; a face in one point is flat too."""
    ax, ay, az = V[j, 0] - V[i, 0], V[j, 1] - V[i, 1], V[j, 2] - V[i, 2]
    bx, by, bz = V[k, 0] - V[i, 0], V[k, 1] - V[i, 1], V[k, 2] - V[i, 2]
    x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    longest = max(_square(V, i, j), _square(V, j, k), _square(V, k, i))
    return np.sqrt(x * x + y * y + z * z) <= FLAT * longest


@compiled
def _joined(flat, opposite, h, v):
    """Is the start of half-edge h joined to vertex v by an edge?"""
    for back in (False, True):
        at = h
        while True:
            if flat[next_halfedge(at)] == v or flat[prev_halfedge(at)] == v:
                return True
            side = at if back else prev_halfedge(at)
            other = opposite[side]
            if other == side:
                break  # the border: go the other way round
            at = next_halfedge(other) if back else other
            if at == h:
                return False
    return False


@compiled
def _count(V, flat, dropped):
    """Flat faces that were not dropped."""
    flats = 0
    for f in range(len(dropped)):
        flats += (not dropped[f]) and _is_flat(V, flat[3 * f], flat[3 * f + 1], flat[3 * f + 2])
    return flats


@compiled(allocates=True)
def _flip(V, flat, opposite):
    """Flips in place; flat faces before, the faces (m,) bool that were dropped on the border, and flat faces after."""
    m = len(flat) // 3
    dropped = np.zeros(m, np.bool_)
    before = _count(V, flat, dropped)
    for _ in range(ROUNDS if before else 0):
        changed = False
        for f in range(m):
            if dropped[f] or not _is_flat(V, flat[3 * f], flat[3 * f + 1], flat[3 * f + 2]):
                continue
            k, longest = 0, -1.0
            for i in range(3):
                length = _square(V, flat[3 * f + i], flat[3 * f + (i + 1) % 3])
                if length > longest:
                    k, longest = i, length
            h = 3 * f + k
            o = opposite[h]
            h1, h2 = next_halfedge(h), prev_halfedge(h)
            if o == h:
                dropped[f] = True
                for e in (h1, h2):
                    if opposite[e] != e:
                        opposite[opposite[e]] = opposite[e]
                changed = True
                continue
            g = o // 3
            o1, o2 = next_halfedge(o), prev_halfedge(o)
            a, b, c, d = flat[h], flat[h1], flat[h2], flat[o2]
            if c == d or _square(V, c, d) == 0 or _joined(flat, opposite, h2, d):
                continue
            flats = 1 + _is_flat(V, flat[3 * g], flat[3 * g + 1], flat[3 * g + 2])
            left = int(_is_flat(V, a, d, c)) + int(_is_flat(V, d, b, c))
            if left > flats or (left == flats and _square(V, c, d) >= longest):
                continue
            old = (o1, o2, h1, h2)
            new = (3 * f, 3 * g, 3 * g + 1, 3 * f + 2)
            across = (opposite[o1], opposite[o2], opposite[h1], opposite[h2])
            flat[3 * f], flat[3 * f + 1], flat[3 * f + 2] = a, d, c
            flat[3 * g], flat[3 * g + 1], flat[3 * g + 2] = d, b, c
            for i in range(4):
                other = across[i]
                for j in range(4):
                    if across[i] == old[j]:
                        other = new[j]
                opposite[new[i]] = other
                if other != new[i]:
                    opposite[other] = new[i]
            opposite[3 * f + 1], opposite[3 * g + 2] = 3 * g + 2, 3 * f + 1
            changed = True
        if not changed:
            break
    return before, dropped, _count(V, flat, dropped)
