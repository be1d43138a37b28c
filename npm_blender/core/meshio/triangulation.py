"""Polygons to triangles: quads by their better diagonal, larger ones by ear clipping (Meisters 1975).

No triangle of a concave polygon lies outside of it.
"""
import numpy as np

from ..geometry import triangle_normal
from ..jit import compiled

WORK = 300  # corners looked at for each corner, on average over a mesh, at most; and so many more:
SPARE = 100_000_000


def triangulate(V: np.ndarray, corners: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Triangles (t, 3) int64 of polygons, in their order and orientation.

    V: (n, 3) float64; corners: (sum of counts,) integer vertex indices, each in 0..n-1; counts: (m,) corners of each
    polygon. A polygon of k >= 3 corners gives k - 2 triangles; those of fewer corners (points, lines) give none.
    Polygons of many thousand corners that cross themselves are cut as they come once WORK is used up.
    """
    corners, counts = np.ascontiguousarray(corners, np.int64), np.ascontiguousarray(counts, np.int64)
    if (counts == 3).all():
        return corners.reshape(-1, 3)
    return _triangulate(np.ascontiguousarray(V, np.float64), corners, counts)


@compiled(allocates=True)
def _triangulate(V, corners, counts):
    out = np.zeros((np.maximum(counts - 2, 0).sum(), 3), np.int64)
    start, made = 0, 0
    work = SPARE + WORK * len(corners)
    for k in counts:
        polygon = corners[start:start + k]
        start += k
        if k == 3:
            out[made] = polygon
        elif k == 4:
            _quad(V, polygon, out[made:made + 2])
        elif k > 4:
            work = _clip_ears(V, polygon, out[made:made + k - 2], work)
        made += max(k - 2, 0)
    return out


@compiled
def _normal(V, polygon):
    """Newell's normal, not normalised."""
    x, y, z = 0.0, 0.0, 0.0
    for i in range(1, len(polygon) - 1):
        a, b, c = triangle_normal(V, polygon[0], polygon[i], polygon[i + 1])
        x, y, z = x + a, y + b, z + c
    return x, y, z


@compiled
def _along(V, i, j, k, normal):
    """Twice the area of the triangle i-j-k as seen along the polygon's normal, times that one's length; below 0: flipped."""
    a = triangle_normal(V, i, j, k)
    return a[0] * normal[0] + a[1] * normal[1] + a[2] * normal[2]


@compiled
def _quad(V, q, out):
    """The two triangles of a quad q (4,): the diagonal that lies inside, of two such the shorter one."""
    n = _normal(V, q)
    along_ac = min(_along(V, q[0], q[1], q[2], n), _along(V, q[0], q[2], q[3], n))
    along_bd = min(_along(V, q[0], q[1], q[3], n), _along(V, q[1], q[2], q[3], n))
    ac, bd = 0.0, 0.0
    for x in range(3):
        ac += (V[q[0], x] - V[q[2], x]) ** 2
        bd += (V[q[1], x] - V[q[3], x]) ** 2
    ac_is_better = ac <= bd
    if (along_ac > 0) != (along_bd > 0):
        ac_is_better = along_ac > 0  # concave: only one diagonal lies inside
    if ac_is_better:
        out[0, 0], out[0, 1], out[0, 2] = q[0], q[1], q[2]
        out[1, 0], out[1, 1], out[1, 2] = q[0], q[2], q[3]
    else:
        out[0, 0], out[0, 1], out[0, 2] = q[0], q[1], q[3]
        out[1, 0], out[1, 1], out[1, 2] = q[1], q[2], q[3]


@compiled
def _turn(p, i, j, k):
    """Twice the signed area of the triangle i-j-k of points p (k, 2): above 0 where the corner j turns left."""
    return (p[j, 0] - p[i, 0]) * (p[k, 1] - p[i, 1]) - (p[j, 1] - p[i, 1]) * (p[k, 0] - p[i, 0])


@compiled
def _same(p, i, j):
    return p[i, 0] == p[j, 0] and p[i, 1] == p[j, 1]


@compiled
def _is_ear(p, i, j, k, before, following, reflex, listed, count):
    """Is the corner i-j-k convex, with no reflex corner in its triangle? How many of the list are left; the work done.

    reflex[:count] are corners, each `listed`; those clipped or convex by now leave the list.
    """
    if _turn(p, i, j, k) <= 0:
        return False, count, 1
    at = 0
    while at < count:
        c = reflex[at]
        if following[c] < 0 or _turn(p, before[c], c, following[c]) > 0:
            count -= 1
            reflex[at], listed[c] = reflex[count], False
            continue
        touches = _same(p, c, i) or _same(p, c, j) or _same(p, c, k)
        if not touches and _turn(p, i, j, c) >= 0 and _turn(p, j, k, c) >= 0 and _turn(p, k, i, c) >= 0:
            return False, count, 1 + at
        at += 1
    return True, count, 1 + at


@compiled(allocates=True)
def _clip_ears(V, polygon, out, work):
    """Triangles out (k - 2, 3) of a polygon (k,); returns the work that is left."""
    k = len(polygon)
    n = _normal(V, polygon)
    x, y = 1, 2  # the plane that the polygon covers most of, seen from its normal
    if abs(n[1]) >= max(abs(n[0]), abs(n[2])):
        x, y = 2, 0
    elif abs(n[2]) >= abs(n[0]):
        x, y = 0, 1
    if n[3 - x - y] < 0:
        x, y = y, x
    p = np.zeros((k, 2))
    for i in range(k):
        p[i, 0], p[i, 1] = V[polygon[i], x], V[polygon[i], y]
    following, before = (np.arange(k) + 1) % k, (np.arange(k) + k - 1) % k
    reflex, listed, count = np.zeros(k, np.int64), np.zeros(k, np.bool_), 0
    for i in range(k):
        if _turn(p, before[i], i, following[i]) <= 0:
            reflex[count], listed[i] = i, True
            count += 1
    j, misses, left = 0, 0, k
    for t in range(k - 2):
        # after a full round without an ear (the outline crosses itself or is flat), take the corner as it is
        while misses < left and work > 0:
            ear, count, done = _is_ear(p, before[j], j, following[j], before, following, reflex, listed, count)
            work -= done
            if ear:
                break
            j, misses = following[j], misses + 1
        a, b = before[j], following[j]
        out[t, 0], out[t, 1], out[t, 2] = polygon[a], polygon[j], polygon[b]
        following[a], before[b], following[j] = b, a, -1
        for c in (a, b):
            if not listed[c] and _turn(p, before[c], c, following[c]) <= 0:
                reflex[count], listed[c] = c, True
                count += 1
        # one corner further on, so that the triangles do not all meet in one corner
        j, misses, left = following[b], 0, left - 1
    return work
