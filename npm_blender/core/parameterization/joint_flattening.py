"""Joint flattening of a stencil before and after its collapse (successive self-parameterization, Liu et al. 2020).

Every vertex gets one position in the plane: those of the ring, shared by both sides, i and j (before) and k (after). A
stencil inside the mesh that is nearly flat is projected on its plane (see `place_flat`). Else the conformal map is tried
first (see `lscm`), with the border through the stencil a straight line where the edge lies on the border; then a convex
map (Tutte 1963), which always succeeds.

The map is a bijection where all triangles of both sides are positively oriented and those round k turn less than once
(exactly once if k is inside): then the stencil after the collapse is a star-shaped polygon, its boundary is simple, and a
positively oriented flattening of the stencil before with that boundary has degree one. `distortion` tests just that.
"""
import numpy as np

from ..jit import compiled
from .convex_map import place_convex
from .lscm import assemble, eliminate, measure, place
from .stencil import ANCHORED, EDGE, INNER, is_of_j, next_on_ring, third_vertex

FLAT = 0.95  # least cosine between the faces of a stencil, before and after, and the plane that it is projected on
MIN_AREA = 1e-7  # twice a flattened triangle's, relative to the squared extent: keeps barycentrics to 1e-9


@compiled(inline="always")
def _owner(stencil, q):
    """The number among the positions of the vertex, i or j, whose face lies on side q of the ring."""
    return stencil.ring_size + 1 if is_of_j(stencil, q) else stencil.ring_size


@compiled(inline="always")
def twice_area(a, b, c):
    """Twice the signed area of the triangle a, b, c (complex)."""
    return (b.real - a.real) * (c.imag - a.imag) - (b.imag - a.imag) * (c.real - a.real)


@compiled(inline="always")
def _abs2(z):
    """The squared length of a complex number."""
    return z.real * z.real + z.imag * z.imag


@compiled(inline="always")
def _stretch(cotangents, f, a, b, c, least):
    """Distortion (s1 / s2 + s2 / s1) / 2 of triangle f flattened to a, b, c; infinite if twice its area is below least.

    s1, s2 are the singular values of its map. With its angles' cotangents that is the sum of cot |opposite side in the
    plane|^2 over twice its area in the plane (Pinkall and Polthier 1993).
    """
    area2 = twice_area(a, b, c)
    if not area2 > least:
        return np.inf
    return (cotangents[f, 0] * _abs2(c - b) + cotangents[f, 1] * _abs2(a - c) + cotangents[f, 2] * _abs2(b - a)) / (2 * area2)


@compiled
def distortion(stencil, uv, cotangents):
    """(largest, mean) distortion of the flattened triangles; infinite if the map is no bijection."""
    sides, kind = stencil.sides, stencil.kind
    i, j = stencil.ring_size, stencil.ring_size + 1
    worst = total = extent2 = 0.0
    k = uv[stencil.ring_size + 2]
    for q in range(stencil.ring_size + 3):
        extent2 = max(extent2, _abs2(uv[q]))
    least = MIN_AREA * extent2
    turn = 0.0
    crossings = 0
    for q in range(sides):
        a, b = uv[q], uv[next_on_ring(stencil, q)]
        d = _stretch(cotangents, q, uv[_owner(stencil, q)], a, b, least)
        e = _stretch(cotangents, sides + 2 + q, k, a, b, least)
        worst = max(worst, d, e)
        total += d + e
        if not worst < np.inf:
            return np.inf, np.inf
        a, b = a - k, b - k
        if kind == INNER:
            if a.imag < 0.0 and b.imag >= 0.0:
                crossings += 1
        else:
            turn += np.arctan2(a.real * b.imag - a.imag * b.real, a.real * b.real + a.imag * b.imag)
    d = _stretch(cotangents, sides, uv[i], uv[j], uv[third_vertex(stencil)], least)
    n = 2 * sides + 1
    if kind != EDGE:
        e = _stretch(cotangents, sides + 1, uv[j], uv[i], uv[stencil.j_start], least)
        d = max(d, e)
        total += e
        n += 1
    worst = max(worst, d)
    total += d
    if not worst < np.inf or (kind == INNER and crossings != 1) or turn >= 2 * np.pi - 1e-6:
        return np.inf, np.inf
    return worst, total / n


@compiled(inline="always")
def _cross(a0, a1, a2, b0, b1, b2):
    """The cross product of two vectors."""
    return a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0


@compiled(inline="always")
def _is_near_plane(X, a, b, ox, oy, oz, nx, ny, nz):
    """Whether the triangle of the point o and vertices a, b has a normal within FLAT of the unit normal n."""
    px, py, pz = _cross(X[a, 0] - ox, X[a, 1] - oy, X[a, 2] - oz, X[b, 0] - ox, X[b, 1] - oy, X[b, 2] - oz)
    along = px * nx + py * ny + pz * nz
    return along > 0.0 and along * along >= FLAT * FLAT * (px * px + py * py + pz * pz)


@compiled
def place_flat(X, stencil, point, uv):
    """Positions uv of an INNER stencil projected on the plane of its summed normal; False where a face, before or after the
    collapse, leans away from that by more than FLAT allows, or is too thin.

    The projection stretches nothing by more than 1 / FLAT, and takes a third of the time of a conformal map.
    """
    ring, i, j = stencil.ring, stencil.i, stencil.j
    x, y, z = point
    xi, yi, zi = X[i, 0], X[i, 1], X[i, 2]
    nx, ny, nz = _summed_normal(X, stencil)
    size = np.sqrt(nx * nx + ny * ny + nz * nz)
    if not size > 1e-60:
        return False
    nx, ny, nz = nx / size, ny / size, nz / size
    for q in range(stencil.ring_size):
        a, b = ring[q], ring[next_on_ring(stencil, q)]
        o = j if is_of_j(stencil, q) else i
        if (not _is_near_plane(X, a, b, x, y, z, nx, ny, nz)
                or not _is_near_plane(X, a, b, X[o, 0], X[o, 1], X[o, 2], nx, ny, nz)):
            return False
    a, b = ring[stencil.j_stop], ring[stencil.j_start]
    if not _is_near_plane(X, j, a, xi, yi, zi, nx, ny, nz) or not _is_near_plane(X, b, j, xi, yi, zi, nx, ny, nz):
        return False
    ex, ey, ez = X[j, 0] - xi, X[j, 1] - yi, X[j, 2] - zi
    fx, fy, fz = _cross(nx, ny, nz, ex, ey, ez)
    ex, ey, ez = _cross(fx, fy, fz, nx, ny, nz)  # the edge, projected
    unit = ex * ex + ey * ey + ez * ez
    if not unit > 1e-60:
        return False
    ex, ey, ez, fx, fy, fz = ex / unit, ey / unit, ez / unit, fx / unit, fy / unit, fz / unit
    r = stencil.ring_size
    for q in range(r + 1):
        if q < r:
            px, py, pz = X[ring[q], 0] - xi, X[ring[q], 1] - yi, X[ring[q], 2] - zi
        else:
            px, py, pz = x - xi, y - yi, z - zi
        uv[q if q < r else r + 2] = complex(px * ex + py * ey + pz * ez, px * fx + py * fy + pz * fz)
    uv[r], uv[r + 1] = 0.0, 1.0
    return _is_oriented(stencil, uv)


@compiled
def _summed_normal(X, stencil):
    """The sum of the area-weighted normals of a closed stencil's faces: that of its boundary, seen from i."""
    ring, i = stencil.ring, stencil.i
    xi, yi, zi = X[i, 0], X[i, 1], X[i, 2]
    nx = ny = nz = 0.0
    for q in range(stencil.ring_size):
        a, b = ring[q], ring[next_on_ring(stencil, q)]
        px, py, pz = _cross(X[a, 0] - xi, X[a, 1] - yi, X[a, 2] - zi, X[b, 0] - xi, X[b, 1] - yi, X[b, 2] - zi)
        nx, ny, nz = nx + px, ny + py, nz + pz
    return nx, ny, nz


@compiled
def _is_oriented(stencil, uv):
    """Whether the positions of an INNER stencil make a bijection: `distortion` without measuring it."""
    r = stencil.ring_size
    extent2, crossings, k = 1.0, 0, uv[r + 2]
    for q in range(r):
        extent2 = max(extent2, _abs2(uv[q]))
    least = MIN_AREA * max(extent2, _abs2(k))
    for q in range(r):
        a, b = uv[q], uv[next_on_ring(stencil, q)]
        if not twice_area(k, a, b) > least or not twice_area(uv[_owner(stencil, q)], a, b) > least:
            return False
        crossings += a.imag < k.imag <= b.imag
    return (crossings == 1 and twice_area(uv[r], uv[r + 1], uv[stencil.j_stop]) > least
            and twice_area(uv[r + 1], uv[r], uv[stencil.j_start]) > least)


@compiled
def _place_border(stencil, work):
    """Positions work.uv of the conformal map of an EDGE stencil, with the border a straight line on both sides of the
    collapse; returns the largest distortion, infinite where no such map is a bijection.

    Three ways, and the one of least mean distortion is taken: 0, k at i with i, j and the first ring vertex in line; 1, k at j
    with the last, i and j in line; 2, all of them in line with k between i and j.
    """
    uv, last = work.uv, stencil.ring_size - 1
    best = np.inf
    chosen, least = -1, np.inf
    for way in range(4):
        if way == 3:  # the chosen one once more, as a later way has overwritten it
            if chosen < 0 or chosen == 2:
                break
            way = chosen
        straight = (way != 1, way != 0, True)
        if not place(stencil.ring_size, work, straight, -1.0 if way == 2 else float(way)):
            continue
        if (straight[0] and not uv[0].real > 1.0) or (straight[1] and not uv[last].real < 0.0):
            continue  # straight, but folded back on itself
        worst, mean = distortion(stencil, uv, work.cotangents)
        if mean < least:
            chosen, least, best = way, mean, worst
    return best


@compiled
def flatten_jointly(X, stencil, point, limit, work):
    """Fill work.uv with the joint flattening of the collapse of stencil.i and stencil.j to a point (Liu et al. 2020).

    X (n, 3) float64: positions; point: a tuple x, y, z; work: a `Workspace`. True if the result is a usable bijection. work.uv
    then holds, with n = stencil.ring_size, the positions of the ring in its first n entries, i = 0 and j = 1 in the next two
    and those of k, the vertex that both become, in the one after. Triangles of both sides are counter-clockwise.
    limit: the largest distortion (s1 / s2 + s2 / s1) / 2 of a triangle that the conformal map may have; else the ring is put
    on a circle. That the ring has the same positions before and after makes the collapse a map of one side to the other:
    a point of a triangle before goes to the point of the same position after.

    >>> import numpy as np
    >>> from npm_blender.core.parameterization import INNER, Stencil, Workspace, flatten_jointly
    >>> X = np.array([[0, 0, 0], [1, 0, 0], [.5, -1, 0], [2, 0, 0], [.5, 1, 0], [-1, 0, 0]])  # i, j, and a ring of four
    >>> ring = np.array([2, 3, 4, 5], np.int32)
    >>> stencil, work = Stencil(INNER, ring, np.zeros(6, np.int32), 4, 4, 0, 2, 0, 1), Workspace.make()
    >>> bool(flatten_jointly(X, stencil, (.5, 0., 0.), 20.0, work))
    True
    >>> [(float(z.real), float(z.imag)) for z in work.uv[:7]]  # it is flat already: the ring; i; j; k
    [(0.5, -1.0), (2.0, 0.0), (0.5, 1.0), (-1.0, 0.0), (0.0, 0.0), (1.0, 0.0), (0.5, 0.0)]
    """
    if stencil.kind == INNER and place_flat(X, stencil, point, work.uv):
        return True
    measure(X, stencil, point, work.cotangents)
    diagonal_k = assemble(stencil, work.cotangents, work.ring_system)
    eliminate(stencil, diagonal_k, work.ring_system, work.end_system)
    best = np.inf
    if stencil.kind == EDGE:
        best = _place_border(stencil, work)
    elif place(stencil.ring_size, work, (False, False, False), 0.0 if stencil.kind == ANCHORED else -1.0):
        best, _ = distortion(stencil, work.uv, work.cotangents)
    if best < np.inf and best <= limit:
        return True
    place_convex(stencil, work.uv)
    best, _ = distortion(stencil, work.uv, work.cotangents)
    return best < np.inf
