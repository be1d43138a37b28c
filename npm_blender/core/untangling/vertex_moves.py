"""Better places for one vertex of a flipped face.

A place is better if it leaves fewer flipped faces round the vertex, over the levels that hold it, or as many and these
less flipped, and if the faces do not leave the surface for it. Tried are straight traces over the surface towards the middle of
the vertex' ring, across the opposite side of the face, and from each neighbour's place towards that middle: a trace that
meets a wall climbs it instead of reaching the place behind it, and a neighbour may lie there. The method is ours.
"""
from typing import NamedTuple

import numpy as np

from ..geometry import (
    FLIPPED_SURFACE,
    evaluate_point,
    move_point,
    not_flipped,
    orientation_cosine,
    orientation_measures,
    trace_geodesic,
)
from ..jit import compiled

FARTHER = 1.02  # times the faces' distance from the surface (see `orientation_measures`) that a step may leave
SHARES = (1.0, 0.5, 1.5)  # of the way to the middle of the ring
CLEAR = (0.3, 0.05)  # height over the opposite side after the step across it, in lengths of that side
SIDE = (1.0, 0.4)  # of the way from a neighbour to the middle of the ring

FLIPPED, COSINES, BULGE, AREA = range(4)  # places in PlaceSearch.score: what `score` returns, in its order


class PlaceSearch(NamedTuple):
    """Work space of the search for a better place of a vertex: tried (3,) float64: barycentrics of the place that is looked at;
    found (3,) float64 and face (1,) int64: barycentrics and face of the best so far, -1: none; score (4,) float64: its score in
    FLIPPED and COSINES, and in BULGE and AREA the most bulge and the least area that a place may leave."""

    tried: np.ndarray
    found: np.ndarray
    face: np.ndarray
    score: np.ndarray

    @staticmethod
    def make() -> "PlaceSearch":
        """Work space for one thread."""
        return PlaceSearch(np.zeros(3), np.zeros(3), np.zeros(1, np.int64), np.zeros(4))


@compiled
def score(rings, points, v, levels, most, highest):
    """Number of flipped faces round v over the first `levels` levels, the sum of their cosines; of the last level the
    bulge and the projected area. Stops at more than `most` flipped ones and at a bulge above `highest`: most places fail
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
            if not not_flipped(product, size, FLIPPED_SURFACE):
                count += 1
                if count > most:
                    return count, total, height, area
                total += orientation_cosine(product, size)
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
def _try_place(surface, rings, points, v, g, search):
    """Score the place (face g, barycentrics search.tried) for v; where it is better than the best so far, and within the limits
    of bulge and area, it becomes the best."""
    best, tried, found = search.score, search.tried, search.found
    evaluate_point(surface, points, v, g, tried)
    flipped, cosines, height, area = score(rings, points, v, len(rings.at), best[FLIPPED], best[BULGE])
    if height > best[BULGE] or area < best[AREA]:
        return
    if flipped < best[FLIPPED] or (flipped == best[FLIPPED] and cosines > best[COSINES] + 1e-6):
        best[FLIPPED], best[COSINES] = flipped, cosines
        found[0], found[1], found[2] = tried[0], tried[1], tried[2]
        search.face[0] = g


@compiled
def _trace_from(surface, rings, points, v, o, x, y, z, search):
    """Try for v the place (x, y, z) away from point o over the surface."""
    w = search.tried
    w[0], w[1], w[2] = points.b[o, 0], points.b[o, 1], points.b[o, 2]
    g = trace_geodesic(surface, points.face[o], w, x, y, z)
    _try_place(surface, rings, points, v, g, search)


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
def relocate_vertex(surface, rings, points, f, c, level, search, thorough, covered):
    """Move corner c of face f, which is of a level, to the best place found; True if it moved.

    A place counts over all levels that hold the vertex. thorough: whether places near the neighbours are tried; covered: share of
    the faces' projected area that is to stay; search: a PlaceSearch.
    """
    P, best = points.P, search.score
    v = rings.F[f, c]
    best[FLIPPED], best[COSINES], best[BULGE], best[AREA] = score(rings, points, v, len(rings.at), np.inf, np.inf)
    best[BULGE] = FARTHER * best[BULGE] + 1e-15
    best[AREA] = covered * best[AREA] if best[AREA] > 0.0 else -np.inf
    search.face[0] = -1
    px, py, pz = P[v, 0], P[v, 1], P[v, 2]
    mx, my, mz = middle(rings, P, v, level)
    for trial in range(5):
        if trial < 3:
            share = SHARES[trial]
            x, y, z = share * (mx - px), share * (my - py), share * (mz - pz)
        else:
            evaluate_point(surface, points, v, points.face[v], points.b[v])
            x, y, z = _across(P, points.N, v, rings.F[f, (c + 1) % 3], rings.F[f, (c + 2) % 3], CLEAR[trial - 3])
        _trace_from(surface, rings, points, v, v, x, y, z, search)
        if best[FLIPPED] == 0:
            break
    if thorough and best[FLIPPED] > 0:
        for k in range(rings.at[level, v], rings.at[level, v + 1]):
            o = rings.around[k]
            for trial in range(2):
                share = SIDE[trial]
                dx, dy, dz = share * (mx - P[o, 0]), share * (my - P[o, 1]), share * (mz - P[o, 2])
                _trace_from(surface, rings, points, v, o, dx, dy, dz, search)
    if search.face[0] < 0:
        evaluate_point(surface, points, v, points.face[v], points.b[v])
        return False
    move_point(surface, points, v, search.face[0], search.found)
    return True
