"""Better places for one vertex of a turned face.

A place is better if it leaves fewer turned faces round the vertex, over the levels that hold it, or as many and these
less turned, and if the faces do not leave the surface for it. Tried are walks towards the middle of the vertex' ring,
across the opposite side of the face, and from each neighbour's place towards that middle: a walk stops at walls that
stand across it, and a neighbour may lie behind one.
"""
from typing import NamedTuple

import numpy as np

from .jit import compiled
from .walk import move, show, walk

FARTHER = 1.02  # times the faces' distance from the surface (see `bulge`) that a step may leave
MARGIN = 0.05  # cosine between face and surface up to which a face counts as turned: the fit still moves it
SHARES = (1.0, 0.5, 1.5)  # of the way to the middle of the ring
CLEAR = (0.3, 0.05)  # height over the opposite side after the step across it, in lengths of that side
SIDE = (1.0, 0.4)  # of the way from a neighbour to the middle of the ring


class Rings(NamedTuple):
    """Levels 1..L in one: faces F and opposite half-edges, concatenated; first face of each level (and the end);
    out (L, n): a half-edge that leaves each vertex in each level, or -1; fixed (n,): vertices that do not move;
    n (L + 1,): number of vertices of each level from the base on, which come first."""

    F: np.ndarray
    opposite: np.ndarray
    first: np.ndarray
    out: np.ndarray
    fixed: np.ndarray
    n: np.ndarray


@compiled
def normal(P, a, b, c):
    """Normal of the triangle of points a, b, c of P, twice as long as its area."""
    ux, uy, uz = P[b, 0] - P[a, 0], P[b, 1] - P[a, 1], P[b, 2] - P[a, 2]
    vx, vy, vz = P[c, 0] - P[a, 0], P[c, 1] - P[a, 1], P[c, 2] - P[a, 2]
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


@compiled
def cosine(F, P, N, f):
    """Cosine between face f of points P and the sum of its corners' normals N."""
    a, b, c = F[f, 0], F[f, 1], F[f, 2]
    nx, ny, nz = normal(P, a, b, c)
    sx, sy, sz = N[a, 0] + N[b, 0] + N[c, 0], N[a, 1] + N[b, 1] + N[c, 1], N[a, 2] + N[b, 2] + N[c, 2]
    size = np.sqrt((nx * nx + ny * ny + nz * nz) * (sx * sx + sy * sy + sz * sz))
    return (nx * sx + ny * sy + nz * sz) / size if size > 1e-30 else 0.0


@compiled
def bulge(F, P, N, f):
    """How far the middle of face f is from the planes of the surface at its corners, times the face's area (times 6)."""
    a, b, c = F[f, 0], F[f, 1], F[f, 2]
    nx, ny, nz = normal(P, a, b, c)
    gx, gy, gz = (P[a, 0] + P[b, 0] + P[c, 0]) / 3, (P[a, 1] + P[b, 1] + P[c, 1]) / 3, (P[a, 2] + P[b, 2] + P[c, 2]) / 3
    height = 0.0
    for k in range(3):
        i = F[f, k]
        height += abs(N[i, 0] * (gx - P[i, 0]) + N[i, 1] * (gy - P[i, 1]) + N[i, 2] * (gz - P[i, 2]))
    return height * np.sqrt(nx * nx + ny * ny + nz * nz)


@compiled
def projected(F, P, N, f):
    """Area of face f projected on the surface at its corners, negative if the face is turned (times 6)."""
    a, b, c = F[f, 0], F[f, 1], F[f, 2]
    nx, ny, nz = normal(P, a, b, c)
    return (nx * (N[a, 0] + N[b, 0] + N[c, 0]) + ny * (N[a, 1] + N[b, 1] + N[c, 1])
            + nz * (N[a, 2] + N[b, 2] + N[c, 2]))


@compiled
def _score(rings, points, v, levels):
    """Number of turned faces round v over the first `levels` levels, the sum of their cosines; of the last level the
    bulge and the projected area."""
    turned, total, height, area = 0, 0.0, 0.0, 0.0
    for level in range(levels):
        h = start = rings.out[level, v]
        if h < 0:
            continue
        while True:
            c = cosine(rings.F, points.P, points.N, h // 3)
            if level == levels - 1:
                height += bulge(rings.F, points.P, points.N, h // 3)
                area += projected(rings.F, points.P, points.N, h // 3)
            if c <= MARGIN:
                turned += 1
                total += c
            h = rings.opposite[h + 2 if h % 3 == 0 else h - 1]
            if h == start:
                break
    return turned, total, height, area


@compiled
def middle(rings, P, v, level):
    """Mean (x, y, z) of the neighbours of v at one level."""
    h = start = rings.out[level, v]
    x = y = z = 0.0
    count = 0
    while True:
        w = rings.F[h // 3, (h + 1) % 3]
        x, y, z = x + P[w, 0], y + P[w, 1], z + P[w, 2]
        count += 1
        h = rings.opposite[h + 2 if h % 3 == 0 else h - 1]
        if h == start:
            break
    return x / count, y / count, z / count


@compiled
def _better(surface, rings, points, v, levels, g, w, best, where):
    """Score the place (g, w) for v; where it beats best (turned, sum), without more than the bulge best[2] and less than the
    area best[3], it is kept in where (4,): barycentrics, face."""
    show(surface, points, v, g, w)
    turned, total, height, area = _score(rings, points, v, levels)
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
def improve(surface, rings, points, f, c, level, levels, w, best, where, thorough, covered):
    """Move corner c of face f, which is of a level, to the best place found over the first `levels` levels.

    True if it moved. thorough: whether places near the neighbours are tried; covered: share of the faces' projected area
    that is to stay. w (3,), best (4,), where (4,): work space.
    """
    P = points.P
    v = rings.F[f, c]
    best[0], best[1], best[2], best[3] = _score(rings, points, v, levels)
    best[2] = FARTHER * best[2] + 1e-15
    best[3] = covered * best[3] if best[3] > 0.0 else -np.inf
    where[3] = -1.0
    px, py, pz = P[v, 0], P[v, 1], P[v, 2]
    mx, my, mz = middle(rings, P, v, level)
    w[0], w[1], w[2] = points.b[v, 0], points.b[v, 1], points.b[v, 2]
    for trial in range(5):
        show(surface, points, v, points.face[v], points.b[v])
        if trial < 3:
            share = SHARES[trial]
            x, y, z = share * (mx - px), share * (my - py), share * (mz - pz)
        else:
            x, y, z = _across(P, points.N, v, rings.F[f, (c + 1) % 3], rings.F[f, (c + 2) % 3], CLEAR[trial - 3])
        w[0], w[1], w[2] = points.b[v, 0], points.b[v, 1], points.b[v, 2]
        g = walk(surface, points.face[v], w, x, y, z)
        _better(surface, rings, points, v, levels, g, w, best, where)
        if best[0] == 0:
            break
    if thorough and best[0] > 0:
        h = start = rings.out[level, v]
        while True:
            o = rings.F[h // 3, (h + 1) % 3]
            for trial in range(2):
                share = SIDE[trial]
                w[0], w[1], w[2] = points.b[o, 0], points.b[o, 1], points.b[o, 2]
                g = walk(surface, points.face[o], w, share * (mx - P[o, 0]), share * (my - P[o, 1]), share * (mz - P[o, 2]))
                _better(surface, rings, points, v, levels, g, w, best, where)
            h = rings.opposite[h + 2 if h % 3 == 0 else h - 1]
            if h == start:
                break
    if where[3] < 0.0:
        show(surface, points, v, points.face[v], points.b[v])
        return False
    move(surface, points, v, int(where[3]), where)
    return True
