"""Straightest geodesics on a triangle mesh (Polthier and Schmies 1998): how the vertices of the levels move on the input surface.

A straight line inside a triangle goes on into the next one as if both lay in one plane: the triangle behind the edge is unfolded
about it. In barycentrics that takes no rotation: the part of a step across the edge is divided by the height of the new corner
over it, and what is left of the step runs along the edge. A line through a vertex goes on in one of the faces there.
"""
from typing import NamedTuple

import numpy as np

from ..jit import compiled
from ..parallel import each

SLICE = 26_000  # points that one thread evaluates at a time
_STEPS = 200  # faces that one trace may cross
_FLAT = 1e-12  # squared sine of an angle below which a triangle has no area
_CANCELLED = 1e-9  # length below which the sum of normals is none


class TraceMesh(NamedTuple):
    """A mesh to trace over: V (n, 3) float64, F (m, 3) int32, opposite half-edges (3 m,) int32, unit vertex normals N (n, 3)
    float64.

    >>> from npm_blender.core import TriMesh
    >>> from npm_blender.core.geometry import TraceMesh, vertex_normals
    >>> from npm_blender.core.mesh import opposite_halfedges
    >>> mesh = TriMesh.from_arrays([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> surface = TraceMesh(mesh.V, mesh.F, opposite_halfedges(mesh.F), vertex_normals(mesh))
    >>> surface.opposite.tolist()  # faces meet in half-edges 2 and 3, the rest is border
    [0, 1, 3, 2, 4, 5]
    """

    V: np.ndarray
    F: np.ndarray
    opposite: np.ndarray
    N: np.ndarray


class SurfacePoints(NamedTuple):
    """Points on a TraceMesh: face (n,) int32 and barycentrics b (n, 3) float64; their positions P (n, 3), in its frame, and
    normals N (n, 3), of length one, or zero where those of the face's corners cancel out. See `points_on`, which makes them.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import SurfacePoints
    >>> points = SurfacePoints(np.zeros(4, np.int32), np.full((4, 3), 1 / 3), np.zeros((4, 3)), np.zeros((4, 3)))
    >>> points._fields, len(points.face)
    (('face', 'b', 'P', 'N'), 4)
    """

    face: np.ndarray
    b: np.ndarray
    P: np.ndarray
    N: np.ndarray


@compiled(inline="always")
def _across(V, a, b, c, w, db, dc):
    """A step in the triangle a, b, c, by the changes db and dc of its barycentrics, unfolded about the edge a -> b into the
    triangle a, b, w on its other side: changes of the barycentrics of b and w there; not finite where w is on that edge."""
    ex, ey, ez = V[b, 0] - V[a, 0], V[b, 1] - V[a, 1], V[b, 2] - V[a, 2]
    ux, uy, uz = V[c, 0] - V[a, 0], V[c, 1] - V[a, 1], V[c, 2] - V[a, 2]
    vx, vy, vz = V[w, 0] - V[a, 0], V[w, 1] - V[a, 1], V[w, 2] - V[a, 2]
    r = 1.0 / (ex * ex + ey * ey + ez * ez)
    s, t = r * (ux * ex + uy * ey + uz * ez), r * (vx * ex + vy * ey + vz * ez)
    size = vx * vx + vy * vy + vz * vz
    ux, uy, uz = ux - s * ex, uy - s * ey, uz - s * ez  # heights over the edge, in both planes
    vx, vy, vz = vx - t * ex, vy - t * ey, vz - t * ez
    height = vx * vx + vy * vy + vz * vz
    if not height > _FLAT * size:
        return np.inf, np.inf
    dw = -dc * np.sqrt((ux * ux + uy * uy + uz * uz) / height)
    return db + dc * s - dw * t, dw


@compiled
def trace_geodesic(surface, f, b, x, y, z):
    """Move the point (face f, barycentrics b (3,)) straight over a TraceMesh by (x, y, z), in its frame, unfolding edges.

    Returns the new face; b changes in place. The step is projected on the plane of face f, and keeps its length over edges.
    Stops at the border, at a face without area, and after _STEPS faces.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import TraceMesh, trace_geodesic, vertex_normals
    >>> from npm_blender.core.mesh import TriMesh, opposite_halfedges
    >>> step = TriMesh.from_arrays([[0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, 0, 1]], [[0, 1, 2], [1, 0, 3]])  # a floor and a wall
    >>> surface, b = TraceMesh(step.V, step.F, opposite_halfedges(step.F), vertex_normals(step)), np.array([0.5, 0.25, 0.25])
    >>> f = trace_geodesic(surface, 0, b, 0.5, 0.0, 0.0)  # from (-0.25, 0.25, 0) to the wall, and on upwards
    >>> f, (b @ step.V[step.F[f]]).tolist()
    (1, [0.0, 0.25, 0.25])
    """
    V, F = surface.V, surface.F
    i, j, k = F[f, 0], F[f, 1], F[f, 2]
    ex, ey, ez = V[j, 0] - V[i, 0], V[j, 1] - V[i, 1], V[j, 2] - V[i, 2]
    gx, gy, gz = V[k, 0] - V[i, 0], V[k, 1] - V[i, 1], V[k, 2] - V[i, 2]
    ee, eg, gg = ex * ex + ey * ey + ez * ez, ex * gx + ey * gy + ez * gz, gx * gx + gy * gy + gz * gz
    det = ee * gg - eg * eg
    if not det > _FLAT * ee * gg:
        return f
    de, dg = x * ex + y * ey + z * ez, x * gx + y * gy + z * gz
    r = 1.0 / det
    d1, d2 = r * (gg * de - eg * dg), r * (ee * dg - eg * de)  # changes of the barycentrics
    d0 = -d1 - d2
    first, b0, b1, b2 = 0, b[0], b[1], b[2]  # the corner of the face to which b0 and d0 belong; b1 and d1: to the next
    for _ in range(_STEPS):
        reach, side = 1.0, -1
        if d0 < 0.0 and b0 + d0 < 0.0:
            reach, side = -b0 / d0, 0
        if d1 < 0.0 and b1 + d1 < 0.0 and -b1 / d1 <= reach:
            reach, side = -b1 / d1, 1
        if d2 < 0.0 and b2 + d2 < 0.0 and -b2 / d2 <= reach:
            reach, side = -b2 / d2, 2
        b0, b1, b2 = max(b0 + reach * d0, 0.0), max(b1 + reach * d1, 0.0), max(b2 + reach * d2, 0.0)
        if side < 0:
            break
        if side == 0:  # out over the side from the next corner, `near`, to the one before, `far`
            b0, near, b_near, b_far, d_far, d_behind = 0.0, first + 1, b1, b2, d2, d0
        elif side == 1:
            b1, near, b_near, b_far, d_far, d_behind = 0.0, first + 2, b2, b0, d0, d1
        else:
            b2, near, b_near, b_far, d_far, d_behind = 0.0, first, b0, b1, d1, d2
        near %= 3
        h = 3 * f + near
        o = surface.opposite[h]
        if o == h:
            break
        left = 1.0 - reach
        d_far, d_new = _across(V, F[f, near], F[f, (near + 1) % 3], F[f, (near + 2) % 3], F[o // 3, (o + 2) % 3],
                               left * d_far, left * d_behind)
        f, first = o // 3, o % 3
        b0, b1, b2, d0, d1, d2 = b_far, b_near, 0.0, d_far, -d_far - d_new, d_new
        if not abs(d_far) < np.inf:
            break
    r = 1.0 / (b0 + b1 + b2)
    b[first], b[(first + 1) % 3], b[(first + 2) % 3] = r * b0, r * b1, r * b2
    return f


@compiled
def evaluate_point(surface, points, v, f, b):
    """Set the position and normal of point v to those at (face f, barycentrics b (3,)), but leave its face and barycentrics as
    they are: to look at a place before the point moves there. P = sum_i b_i V_i; N = sum_i b_i N_i, brought to length one.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import TraceMesh, evaluate_point, points_on
    >>> up = np.array([[0.0, 0, 1]] * 3)
    >>> surface = TraceMesh(np.eye(3), np.array([[0, 1, 2]], np.int32), np.arange(3, dtype=np.int32), up)
    >>> points = points_on(surface, np.zeros(1, np.int32), np.array([[1.0, 0, 0]]))
    >>> evaluate_point(surface, points, 0, 0, np.array([0.0, 0.5, 0.5]))
    >>> points.P.tolist(), points.b.tolist()
    ([[0.0, 0.5, 0.5]], [[1.0, 0.0, 0.0]])
    """
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
def move_point(surface, points, v, f, b):
    """Put point v at (face f, barycentrics b (3,)), with its position and normal there.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import TraceMesh, move_point, points_on
    >>> up = np.array([[0.0, 0, 1]] * 3)
    >>> surface = TraceMesh(np.eye(3), np.array([[0, 1, 2]], np.int32), np.arange(3, dtype=np.int32), up)
    >>> points = points_on(surface, np.zeros(1, np.int32), np.array([[1.0, 0, 0]]))
    >>> move_point(surface, points, 0, 0, np.array([0.0, 0.5, 0.5]))
    >>> points.P.tolist(), points.b.tolist()
    ([[0.0, 0.5, 0.5]], [[0.0, 0.5, 0.5]])
    """
    points.face[v] = f
    points.b[v, 0], points.b[v, 1], points.b[v, 2] = b[0], b[1], b[2]
    evaluate_point(surface, points, v, f, b)


@compiled
def _evaluate_all(surface, points, first, last):
    for v in range(first, min(last, len(points.face))):
        evaluate_point(surface, points, v, points.face[v], points.b[v])


def points_on(surface: TraceMesh, face: np.ndarray, barycentric: np.ndarray) -> SurfacePoints:
    """Points that can be moved: copies of face (n,) int32 and barycentric (n, 3) float64, with positions and normals.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import TraceMesh, points_on
    >>> up = np.array([[0.0, 0, 1]] * 3)
    >>> surface = TraceMesh(np.eye(3), np.array([[0, 1, 2]], np.int32), np.arange(3, dtype=np.int32), up)
    >>> points = points_on(surface, np.zeros(2, np.int32), np.array([[1.0, 0, 0], [0.5, 0.25, 0.25]]))
    >>> points.P.tolist(), points.N.tolist()
    ([[1.0, 0.0, 0.0], [0.5, 0.25, 0.25]], [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]])
    """
    points = SurfacePoints(face.copy(), barycentric.copy(), np.empty((len(face), 3)), np.empty((len(face), 3)))
    each(lambda first: _evaluate_all(surface, points, first, first + SLICE), range(0, len(face), SLICE))
    return points
