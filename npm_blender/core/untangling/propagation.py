"""When a vertex has moved, the finer ones follow: each goes to the middle of its edge again."""
import numpy as np

from ..geometry import evaluate_point, move_point, trace_geodesic
from ..jit import compiled
from .trial import count_flipped

NEAR = 0.05  # distance from the middle of an edge, in its lengths, that ends the search for a place there


@compiled
def to_midpoint(surface, points, v, i, j, tried, found):
    """Put v near the middle between i and j: the nearest to it of three traces towards it, which start from v, from i and from j,
    or the first that comes near. tried (3,), found (3,): work space for barycentrics."""
    P = points.P
    mx, my, mz = (P[i, 0] + P[j, 0]) / 2, (P[i, 1] + P[j, 1]) / 2, (P[i, 2] + P[j, 2]) / 2
    enough = NEAR * NEAR * ((P[i, 0] - P[j, 0]) ** 2 + (P[i, 1] - P[j, 1]) ** 2 + (P[i, 2] - P[j, 2]) ** 2)
    nearest, face = np.inf, -1
    ox, oy, oz = P[v, 0], P[v, 1], P[v, 2]
    for trial in range(3):
        o = v if trial == 0 else (i if trial == 1 else j)
        tried[0], tried[1], tried[2] = points.b[o, 0], points.b[o, 1], points.b[o, 2]
        x, y, z = mx - ox, my - oy, mz - oz
        if trial > 0:
            x, y, z = mx - P[o, 0], my - P[o, 1], mz - P[o, 2]
        g = trace_geodesic(surface, points.face[o], tried, x, y, z)
        evaluate_point(surface, points, v, g, tried)
        gap = (P[v, 0] - mx) ** 2 + (P[v, 1] - my) ** 2 + (P[v, 2] - mz) ** 2
        if gap < nearest:
            nearest, face = gap, g
            found[0], found[1], found[2] = tried[0], tried[1], tried[2]
        if gap <= enough:
            break
    move_point(surface, points, v, face, found)


@compiled
def propagate(surface, rings, points, level, region, most):
    """Put the region's finer vertices on the middles of their edges, after those of a level (-1: of the base) moved.

    Stops before the first level that comes with more than `most` flipped faces in all; returns how many vertices followed,
    and whether all did.
    """
    first = start = region.vertices_to[level] if level >= 0 else 1
    flipped, faces, search = 0, 0, region.search
    for k in range(len(rings.at)):
        if k > level:
            for i in range(first, region.vertices_to[k]):
                v = region.vertices[i]
                to_midpoint(surface, points, v, rings.parents[v, 0], rings.parents[v, 1], search.tried, search.found)
            first = region.vertices_to[k]
        if k >= level:
            flipped += count_flipped(rings, points, region, faces, region.faces_to[k], most - flipped)
            faces = region.faces_to[k]
            if flipped > most:
                return first - start, False
    return first - start, True
