"""Joint flattening of the patch before and after a collapse (successive self-parameterization, Liu et al. 2020).

The vertices of the patch get one planar position each: the ring (shared by both sides), i and j (before) and k (after).
The conformal map is tried first (see `conformal`), with the border through the patch a straight line where the edge
lies on the border; then a convex map (Tutte 1963), which always succeeds.

The map is a bijection of the patch where all triangles of both sides are positively oriented and the fan of k turns
less than once (exactly once if k is inside): then the after-side is a star-shaped polygon, its boundary is simple, and
a positively oriented flattening of the before-side with that boundary has degree one. `check` tests just that.
"""
import numpy as np

from .conformal import assemble, eliminate, measure, place
from .halfedge import ANCHORED, EDGE, INNER
from .jit import compiled

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
def flatten(X, ring, r, t, s1, s2, kind, i, j, x, y, z, limit, uv, cots, S, B, A):
    """Fill uv (r + 3,) with the joint flattening of the collapse i, j -> (x, y, z); True if it is a usable bijection.

    limit: largest distortion (s1 / s2 + s2 / s1) / 2 of a triangle that the conformal map may have; else the circle is
    taken. cots, S, B, A are work space.
    """
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
