"""A vertex that moved takes the finer ones along: each goes to the middle of its edge again."""
import numpy as np

from ..geometry import evaluate_at, put_at, trace_geodesic
from ..jit import compiled
from .trial import NEAR, turned


@compiled
def to_midpoint(surface, points, v, i, j, w, u):
    """Put v near the middle between i and j: the best of three walks, from its own place and from theirs, or the first that
    comes near."""
    P = points.P
    mx, my, mz = (P[i, 0] + P[j, 0]) / 2, (P[i, 1] + P[j, 1]) / 2, (P[i, 2] + P[j, 2]) / 2
    enough = NEAR * NEAR * ((P[i, 0] - P[j, 0]) ** 2 + (P[i, 1] - P[j, 1]) ** 2 + (P[i, 2] - P[j, 2]) ** 2)
    nearest, face = np.inf, -1
    ox, oy, oz = P[v, 0], P[v, 1], P[v, 2]
    for trial in range(3):
        o = v if trial == 0 else (i if trial == 1 else j)
        w[0], w[1], w[2] = points.b[o, 0], points.b[o, 1], points.b[o, 2]
        x, y, z = mx - ox, my - oy, mz - oz
        if trial > 0:
            x, y, z = mx - P[o, 0], my - P[o, 1], mz - P[o, 2]
        g = trace_geodesic(surface, points.face[o], w, x, y, z)
        evaluate_at(surface, points, v, g, w)
        gap = (P[v, 0] - mx) ** 2 + (P[v, 1] - my) ** 2 + (P[v, 2] - mz) ** 2
        if gap < nearest:
            nearest, face = gap, g
            u[0], u[1], u[2] = w[0], w[1], w[2]
        if gap <= enough:
            break
    put_at(surface, points, v, face, u)


@compiled
def propagate(surface, rings, points, level, patch, most):
    """Put the patch's finer vertices on the middles of their edges, after those of a level (-1: of the base) moved.

    Stops before the first level that comes with more than `most` turned faces in all; returns how many vertices were
    carried, and whether all.
    """
    first = start = patch.vertices_to[level] if level >= 0 else 1
    found, faces = 0, 0
    for k in range(len(rings.at)):
        if k > level:
            for i in range(first, patch.vertices_to[k]):
                v = patch.vertices[i]
                to_midpoint(surface, points, v, rings.parents[v, 0], rings.parents[v, 1], patch.w, patch.where)
            first = patch.vertices_to[k]
        if k >= level:
            found += turned(rings, points, patch, faces, patch.faces_to[k], most - found)
            faces = patch.faces_to[k]
            if found > most:
                return first - start, False
    return first - start, True
