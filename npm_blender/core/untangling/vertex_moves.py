"""Better places for one vertex of a turned face.

A place is better if it leaves fewer turned faces round the vertex, over the levels that hold it, or as many and these
less turned, and if the faces do not leave the surface for it. Tried are walks towards the middle of the vertex' ring,
across the opposite side of the face, and from each neighbour's place towards that middle: a walk stops at walls that
stand across it, and a neighbour may lie behind one.
"""
import numpy as np

from ..geometry import evaluate_at, not_flipped, orientation_measures, put_at, trace_geodesic
from ..jit import compiled

FARTHER = 1.02  # times the faces' distance from the surface (see `orientation_measures`) that a step may leave
SHARES = (1.0, 0.5, 1.5)  # of the way to the middle of the ring
CLEAR = (0.3, 0.05)  # height over the opposite side after the step across it, in lengths of that side
SIDE = (1.0, 0.4)  # of the way from a neighbour to the middle of the ring


@compiled
def score(rings, points, v, levels, most, highest):
    """Number of turned faces round v over the first `levels` levels, the sum of their cosines; of the last level the
    bulge and the projected area. Stops at more than `most` turned ones and at a bulge above `highest`: most places fail
    at their first faces."""
    P, N = points.P, points.N
    count, total, height, area = 0, 0.0, 0.0, 0.0
    for level in range(levels - 1, -1, -1):
        first, end = rings.at[level, v], rings.at[level, v + 1]
        for k in range(first, end):
            p, q = rings.around[k], rings.around[k + 1 if k + 1 < end else first]
            product, size, bulge = orientation_measures(P, N, v, p, q)
            if level == levels - 1:
                height += bulge
                area += product
                if height > highest:
                    return count, total, height, area
            if not not_flipped(product, size):
                count += 1
                if count > most:
                    return count, total, height, area
                total += product / np.sqrt(size) if size > 1e-60 else 0.0
    return count, total, height, area


@compiled
def middle(rings, P, v, level):
    """Mean (x, y, z) of the neighbours of v at one level."""
    x = y = z = 0.0
    first, end = rings.at[level, v], rings.at[level, v + 1]
    for k in range(first, end):
        w = rings.around[k]
        x, y, z = x + P[w, 0], y + P[w, 1], z + P[w, 2]
    return x / (end - first), y / (end - first), z / (end - first)


@compiled
def _better(surface, rings, points, v, levels, g, w, best, where):
    """Score the place (g, w) for v; where it beats best (turned, sum), without more than the bulge best[2] and less than the
    area best[3], it is kept in where (4,): barycentrics, face."""
    evaluate_at(surface, points, v, g, w)
    turned, total, height, area = score(rings, points, v, levels, best[0], best[2])
    if height > best[2] or area < best[3]:
        return
    if turned < best[0] or (turned == best[0] and total > best[1] + 1e-6):
        best[0], best[1] = turned, total
        where[0], where[1], where[2], where[3] = w[0], w[1], w[2], g


@compiled
def _across(P, N, v, p, q, clear):
    """The step (x, y, z) that takes v of the face v, p, q to a height of `clear` lengths over the side p, q."""
    sx, sy, sz = N[v, 0] + N[p, 0] + N[q, 0], N[v, 1] + N[p, 1] + N[q, 1], N[v, 2] + N[p, 2] + N[q, 2]
    ex, ey, ez = P[q, 0] - P[p, 0], P[q, 1] - P[p, 1], P[q, 2] - P[p, 2]
    gx, gy, gz = sy * ez - sz * ey, sz * ex - sx * ez, sx * ey - sy * ex
    high = (P[v, 0] - P[p, 0]) * gx + (P[v, 1] - P[p, 1]) * gy + (P[v, 2] - P[p, 2]) * gz
    gg = gx * gx + gy * gy + gz * gz + 1e-300
    t = (clear * np.sqrt((ex * ex + ey * ey + ez * ez) * gg) - high) / gg
    return t * gx, t * gy, t * gz


@compiled
def relocate_vertex(surface, rings, points, f, c, level, levels, w, best, where, thorough, covered):
    """Move corner c of face f, which is of a level, to the best place found over the first `levels` levels.

    True if it moved. thorough: whether places near the neighbours are tried; covered: share of the faces' projected area
    that is to stay. w (3,), best (4,), where (4,): work space.
    """
    P = points.P
    v = rings.F[f, c]
    best[0], best[1], best[2], best[3] = score(rings, points, v, levels, np.inf, np.inf)
    best[2] = FARTHER * best[2] + 1e-15
    best[3] = covered * best[3] if best[3] > 0.0 else -np.inf
    where[3] = -1.0
    px, py, pz = P[v, 0], P[v, 1], P[v, 2]
    mx, my, mz = middle(rings, P, v, level)
    for trial in range(5):
        if trial < 3:
            share = SHARES[trial]
            x, y, z = share * (mx - px), share * (my - py), share * (mz - pz)
        else:
            evaluate_at(surface, points, v, points.face[v], points.b[v])
            x, y, z = _across(P, points.N, v, rings.F[f, (c + 1) % 3], rings.F[f, (c + 2) % 3], CLEAR[trial - 3])
        w[0], w[1], w[2] = points.b[v, 0], points.b[v, 1], points.b[v, 2]
        g = trace_geodesic(surface, points.face[v], w, x, y, z)
        _better(surface, rings, points, v, levels, g, w, best, where)
        if best[0] == 0:
            break
    if thorough and best[0] > 0:
        for k in range(rings.at[level, v], rings.at[level, v + 1]):
            o = rings.around[k]
            for trial in range(2):
                share = SIDE[trial]
                w[0], w[1], w[2] = points.b[o, 0], points.b[o, 1], points.b[o, 2]
                dx, dy, dz = share * (mx - P[o, 0]), share * (my - P[o, 1]), share * (mz - P[o, 2])
                g = trace_geodesic(surface, points.face[o], w, dx, dy, dz)
                _better(surface, rings, points, v, levels, g, w, best, where)
    if where[3] < 0.0:
        evaluate_at(surface, points, v, points.face[v], points.b[v])
        return False
    put_at(surface, points, v, int(where[3]), where)
    return True
