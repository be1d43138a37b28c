"""Joint flattening of the patch before and after a collapse (successive self-parameterization, Liu et al. 2020).

The vertices of the patch get one planar position each: the ring (shared by both sides), i and j (before) and k (after).
A patch inside the mesh that is nearly flat is projected on its plane (see `place_flat`). Else the conformal map is tried
first (see `conformal`), with the border through the patch a straight line where the edge
lies on the border; then a convex map (Tutte 1963), which always succeeds.

The map is a bijection of the patch where all triangles of both sides are positively oriented and the fan of k turns
less than once (exactly once if k is inside): then the after-side is a star-shaped polygon, its boundary is simple, and
a positively oriented flattening of the before-side with that boundary has degree one. `check` tests just that.
"""
import numpy as np

from ..jit import compiled
from .lscm import assemble, eliminate, measure, place
from .stencil import ANCHORED, EDGE, INNER

FLAT = 0.95  # least cosine between the faces of a patch, before and after, and the plane that it is projected on
MIN_AREA = 1e-7  # twice a flattened triangle's, relative to the squared extent: keeps barycentrics to 1e-9


@compiled(inline="always")
def _owner(q, s1, s2, r):
    return r + 1 if s1 <= q < s2 else r


@compiled(inline="always")
def twice_area(a, b, c):
    """Twice the signed area of the triangle a, b, c (complex)."""
    return (b.real - a.real) * (c.imag - a.imag) - (b.imag - a.imag) * (c.real - a.real)


@compiled(inline="always")
def _abs2(z):
    return z.real * z.real + z.imag * z.imag


@compiled(inline="always")
def _stretch(cots, f, a, b, c, least):
    """Distortion (s1 / s2 + s2 / s1) / 2 of triangle f flattened to a, b, c; infinite if twice its area is below least."""
    area2 = twice_area(a, b, c)
    if not area2 > least:
        return np.inf
    return (cots[f, 0] * _abs2(c - b) + cots[f, 1] * _abs2(a - c) + cots[f, 2] * _abs2(b - a)) / (2 * area2)


@compiled
def check(r, t, s1, s2, kind, uv, cots):
    """(largest, mean) distortion of the flattened triangles; infinite if the map is no bijection."""
    worst = total = extent2 = 0.0
    k = uv[r + 2]
    for q in range(r + 3):
        extent2 = max(extent2, _abs2(uv[q]))
    least = MIN_AREA * extent2
    turn = 0.0
    crossings = 0
    for q in range(t):
        a, b = uv[q], uv[q + 1 if q + 1 < r else 0]
        d = _stretch(cots, q, uv[_owner(q, s1, s2, r)], a, b, least)
        e = _stretch(cots, t + 2 + q, k, a, b, least)
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
    d = _stretch(cots, t, uv[r], uv[r + 1], uv[s2 if s2 < r else 0], least)
    n = 2 * t + 1
    if kind != EDGE:
        e = _stretch(cots, t + 1, uv[r + 1], uv[r], uv[s1], least)
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
def _stays(X, a, b, ox, oy, oz, nx, ny, nz):
    """Whether the triangle of the point o and vertices a, b has a normal within FLAT of the unit normal n."""
    px, py, pz = _cross(X[a, 0] - ox, X[a, 1] - oy, X[a, 2] - oz, X[b, 0] - ox, X[b, 1] - oy, X[b, 2] - oz)
    along = px * nx + py * ny + pz * nz
    return along > 0.0 and along * along >= FLAT * FLAT * (px * px + py * py + pz * pz)


@compiled
def place_flat(X, ring, r, s1, s2, i, j, x, y, z, uv):
    """Positions uv (r + 3,) of an INNER patch projected on the plane of its summed normal; False where a face, before or
    after the collapse, leans away from that by more than FLAT allows, or is too thin.

    The projection stretches nothing by more than 1 / FLAT, and takes a third of the time of a conformal map.
    """
    xi, yi, zi = X[i, 0], X[i, 1], X[i, 2]
    nx = ny = nz = 0.0
    for q in range(r):  # the summed normal of a disk is that of its boundary
        a, b = ring[q], ring[q + 1 if q + 1 < r else 0]
        px, py, pz = _cross(X[a, 0] - xi, X[a, 1] - yi, X[a, 2] - zi, X[b, 0] - xi, X[b, 1] - yi, X[b, 2] - zi)
        nx, ny, nz = nx + px, ny + py, nz + pz
    size = np.sqrt(nx * nx + ny * ny + nz * nz)
    if not size > 1e-60:
        return False
    nx, ny, nz = nx / size, ny / size, nz / size
    for q in range(r):
        a, b = ring[q], ring[q + 1 if q + 1 < r else 0]
        o = j if s1 <= q < s2 else i
        if not _stays(X, a, b, x, y, z, nx, ny, nz) or not _stays(X, a, b, X[o, 0], X[o, 1], X[o, 2], nx, ny, nz):
            return False
    a, b = ring[s2], ring[s1]
    if not _stays(X, j, a, xi, yi, zi, nx, ny, nz) or not _stays(X, b, j, xi, yi, zi, nx, ny, nz):
        return False
    ex, ey, ez = X[j, 0] - xi, X[j, 1] - yi, X[j, 2] - zi
    fx, fy, fz = _cross(nx, ny, nz, ex, ey, ez)
    ex, ey, ez = _cross(fx, fy, fz, nx, ny, nz)  # the edge, projected
    unit = ex * ex + ey * ey + ez * ez
    if not unit > 1e-60:
        return False
    ex, ey, ez, fx, fy, fz = ex / unit, ey / unit, ez / unit, fx / unit, fy / unit, fz / unit
    for q in range(r + 1):
        if q < r:
            px, py, pz = X[ring[q], 0] - xi, X[ring[q], 1] - yi, X[ring[q], 2] - zi
        else:
            px, py, pz = x - xi, y - yi, z - zi
        uv[q if q < r else r + 2] = complex(px * ex + py * ey + pz * ez, px * fx + py * fy + pz * fz)
    uv[r], uv[r + 1] = 0.0, 1.0
    extent2, crossings, k = 1.0, 0, uv[r + 2]
    for q in range(r):
        extent2 = max(extent2, _abs2(uv[q]))
    least = MIN_AREA * max(extent2, _abs2(k))
    for q in range(r):
        a, b = uv[q], uv[q + 1 if q + 1 < r else 0]
        if not twice_area(k, a, b) > least or not twice_area(uv[_owner(q, s1, s2, r)], a, b) > least:
            return False
        crossings += a.imag < k.imag <= b.imag
    return crossings == 1 and twice_area(uv[r], uv[r + 1], uv[s2]) > least and twice_area(uv[r + 1], uv[r], uv[s1]) > least


@compiled
def place_convex(r, s1, s2, kind, uv):
    """Positions uv (r + 3,) with the patch's boundary on a circle (Tutte 1963): always a bijection, but less conformal.

    Where the border edge allows it the border is a diameter with i, j and k on it; at an ear (a border vertex with one
    face) the straight part has three vertices, and k takes the place of the end that stays a corner.
    """
    i, j, k = r, r + 1, r + 2
    straight = kind == EDGE and 0 < s2 < r - 1
    for q in range(r):
        if kind == INNER:
            angle = 2 * np.pi * q / r
        elif straight:
            angle = np.pi * q / (r - 1)
        else:
            angle = 2 * np.pi * (q + 1) / (r + 1)
        uv[q] = complex(np.cos(angle), np.sin(angle))
    if straight:
        uv[0], uv[r - 1] = 1.0, -1.0
        uv[i], uv[j], uv[k] = -1 / 3, 1 / 3, 0.0
    elif kind == EDGE and s2 == 0:
        uv[j], uv[k] = 1.0, 1.0
        uv[i] = (uv[r - 1] + uv[j]) / 2
    elif kind == EDGE:
        uv[i], uv[k] = 1.0, 1.0
        uv[j] = (uv[0] + uv[i]) / 2
    else:
        at_j = complex(0.0, 0.0)
        for q in range(s1, s2 + 1):
            at_j += uv[q if q < r else 0]
        n_j = s2 - s1 + 2
        if kind == ANCHORED:
            uv[i], uv[k] = 1.0, 1.0
            uv[j] = (at_j + uv[i]) / n_j
        else:
            at_i = uv[0]
            for q in range(s2, r):
                at_i += uv[q]
            n_i = r - s2 + 2
            uv[i] = (n_j * at_i + at_j) / (n_i * n_j - 1)
            uv[j] = (at_j + uv[i]) / n_j
            uv[k] = 0.0
    origin, unit = uv[i], uv[j] - uv[i]
    for q in range(r + 3):
        uv[q] = (uv[q] - origin) / unit
    if straight:
        for q in (0, r - 1, i, j, k):
            uv[q] = uv[q].real


@compiled
def flatten_jointly(X, ring, r, t, s1, s2, kind, i, j, x, y, z, limit, uv, cots, S, B, A):
    """Fill uv (r + 3,) with the joint flattening of the collapse i, j -> (x, y, z); True if it is a usable bijection.

    limit: largest distortion (s1 / s2 + s2 / s1) / 2 of a triangle that the conformal map may have; else the circle is
    taken. cots, S, B, A are work space.
    """
    if kind == INNER and place_flat(X, ring, r, s1, s2, i, j, x, y, z, uv):
        return True
    measure(X, ring, r, t, s1, s2, kind, i, j, x, y, z, cots)
    kk = assemble(r, t, s1, s2, kind, cots, S)
    eliminate(r, t, kk, S, B)
    best = np.inf
    if kind != EDGE:
        if place(r, S, B, (False, False, False), 0.0 if kind == ANCHORED else -1.0, A, uv):
            best, _ = check(r, t, s1, s2, kind, uv, cots)
    else:
        # k at i with i, j, first straight; k at j with last, i, j straight; all of them straight with k between
        chosen, least = -1, np.inf
        for way in range(4):
            if way == 3:
                if chosen < 0 or chosen == 2:
                    break
                way = chosen
            flat = (way != 1, way != 0, True)
            if not place(r, S, B, flat, -1.0 if way == 2 else float(way), A, uv):
                continue
            if (flat[0] and not uv[0].real > 1.0) or (flat[1] and not uv[r - 1].real < 0.0):
                continue  # straight, but folded back on itself
            worst, mean = check(r, t, s1, s2, kind, uv, cots)
            if mean < least:
                chosen, least, best = way, mean, worst
    if best < np.inf and best <= limit:
        return True
    place_convex(r, s1, s2, kind, uv)
    best, _ = check(r, t, s1, s2, kind, uv, cots)
    return best < np.inf
