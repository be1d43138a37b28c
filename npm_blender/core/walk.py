"""Straight walks over a triangle mesh: how the vertices of the levels move on the input surface."""
from typing import NamedTuple

import numpy as np

from .jit import compiled
from .parallel import each

SLICE = 26_000  # points that one thread shows at a time
_STEPS = 200  # faces that one walk may cross
_CANCELLED = 1e-9  # length below which the sum of normals is none


class Surface(NamedTuple):
    """The input: V (n, 3), F (m, 3) int32, opposite (3 m,) int32, vertex normals N (n, 3)."""

    V: np.ndarray
    F: np.ndarray
    opposite: np.ndarray
    N: np.ndarray


class Points(NamedTuple):
    """Points on a surface: face (n,) int32 and barycentric b (n, 3); their positions P and normals N (n, 3), of length
    one, or zero where those of the face's corners cancel out."""

    face: np.ndarray
    b: np.ndarray
    P: np.ndarray
    N: np.ndarray


@compiled
def _unfolded(V, a, b, c, w, x, y, z):
    """The vector (x, y, z) in the plane of the triangle a, b, c, turned about the edge a -> b into that of a, b, w on its other
    side."""
    ex, ey, ez = V[b, 0] - V[a, 0], V[b, 1] - V[a, 1], V[b, 2] - V[a, 2]
    r = 1.0 / (ex * ex + ey * ey + ez * ez + 1e-300)
    ux, uy, uz = V[c, 0] - V[a, 0], V[c, 1] - V[a, 1], V[c, 2] - V[a, 2]
    vx, vy, vz = V[w, 0] - V[a, 0], V[w, 1] - V[a, 1], V[w, 2] - V[a, 2]
    s, t = r * (ux * ex + uy * ey + uz * ez), r * (vx * ex + vy * ey + vz * ez)
    ux, uy, uz = ux - s * ex, uy - s * ey, uz - s * ez  # heights over the edge, in both planes
    vx, vy, vz = vx - t * ex, vy - t * ey, vz - t * ez
    along = r * (x * ex + y * ey + z * ez)
    across = -(x * ux + y * uy + z * uz) / (np.sqrt((ux * ux + uy * uy + uz * uz) * (vx * vx + vy * vy + vz * vz)) + 1e-300)
    return along * ex + across * vx, along * ey + across * vy, along * ez + across * vz


@compiled
def walk(surface, f, b, x, y, z):
    """Move the point (face f, barycentrics b) straight over the surface by (x, y, z), unfolding edges; b changes.

    Returns the new face. Stops at the border, at a face without area, and after _STEPS faces.
    """
    V, F = surface.V, surface.F
    for _ in range(_STEPS):
        i, j, k = F[f, 0], F[f, 1], F[f, 2]
        ex, ey, ez = V[j, 0] - V[i, 0], V[j, 1] - V[i, 1], V[j, 2] - V[i, 2]
        gx, gy, gz = V[k, 0] - V[i, 0], V[k, 1] - V[i, 1], V[k, 2] - V[i, 2]
        ee, eg, gg = ex * ex + ey * ey + ez * ez, ex * gx + ey * gy + ez * gz, gx * gx + gy * gy + gz * gz
        det = ee * gg - eg * eg
        if not det > 1e-12 * ee * gg:
            return f
        de, dg = x * ex + y * ey + z * ez, x * gx + y * gy + z * gz
        r = 1.0 / det
        s, t = r * (gg * de - eg * dg), r * (ee * dg - eg * de)
        x, y, z = s * ex + t * gx, s * ey + t * gy, s * ez + t * gz
        reach, side = 1.0, -1
        for c in range(3):
            step = -s - t if c == 0 else (s if c == 1 else t)
            if step < 0.0 and b[c] + step < 0.0 and -b[c] / step <= reach:
                reach, side = max(-b[c] / step, 0.0), c
        b[0], b[1], b[2] = max(b[0] - reach * (s + t), 0.0), max(b[1] + reach * s, 0.0), max(b[2] + reach * t, 0.0)
        if side >= 0:
            b[side] = 0.0
        r = 1.0 / (b[0] + b[1] + b[2])
        b[0], b[1], b[2] = r * b[0], r * b[1], r * b[2]
        if side < 0:
            return f
        near, far = (side + 1) % 3, (side + 2) % 3
        h = 3 * f + near
        o = surface.opposite[h]
        if o == h:
            return f
        g, at = o // 3, o % 3
        left = 1.0 - reach
        x, y, z = _unfolded(V, F[f, near], F[f, far], F[f, side], F[g, (at + 2) % 3], left * x, left * y, left * z)
        c0, c1 = b[near], b[far]
        b[at], b[(at + 1) % 3], b[(at + 2) % 3] = c1, c0, 0.0
        f = g
    return f


@compiled
def show(surface, points, v, f, b):
    """Set the position and normal of point v to those of (face f, barycentrics b), but leave its face as it is."""
    i, j, k = surface.F[f, 0], surface.F[f, 1], surface.F[f, 2]
    P, N = points.P, points.N
    size = 0.0
    for c in range(3):
        P[v, c] = b[0] * surface.V[i, c] + b[1] * surface.V[j, c] + b[2] * surface.V[k, c]
        N[v, c] = b[0] * surface.N[i, c] + b[1] * surface.N[j, c] + b[2] * surface.N[k, c]
        size += N[v, c] * N[v, c]
    r = 1.0 / np.sqrt(size) if size > _CANCELLED * _CANCELLED else 0.0
    for c in range(3):
        N[v, c] *= r


@compiled
def move(surface, points, v, f, b):
    """Put point v at (face f, barycentrics b)."""
    points.face[v] = f
    points.b[v, 0], points.b[v, 1], points.b[v, 2] = b[0], b[1], b[2]
    show(surface, points, v, f, b)


@compiled
def _show_all(surface, points, first, last):
    for v in range(first, min(last, len(points.face))):
        show(surface, points, v, points.face[v], points.b[v])


def points_on(surface: Surface, face: np.ndarray, barycentric: np.ndarray) -> Points:
    """Points that can be moved: copies of face (n,) int32 and barycentric (n, 3), with positions and normals."""
    points = Points(face.copy(), barycentric.copy(), np.empty((len(face), 3)), np.empty((len(face), 3)))
    each(lambda first: _show_all(surface, points, first, first + SLICE), range(0, len(face), SLICE))
    return points
