"""Base vertices whose point of the map lies far from them return to their own position, and the finer vertices follow.

Where faces are long and flat, as in models of machine parts, the flattenings of many collapses push the point of a base
vertex along the surface, and all faces round it with it. Kept is what flips no more faces and is no worse otherwise
(see `trial.better`). The method is ours.
"""
from ..geometry import move_point, trace_geodesic
from ..jit import compiled
from .propagation import propagate
from .trial import TIME, add, begin, better, commit, fitness, gather, restore, save

FAR = 0.1  # distance from its own position, in lengths of an edge of level 1, from which on a vertex returns
STEPS = 4  # traces over the surface, each straight towards that position
NEARER = 0.7  # share of the distance that may be left


@compiled
def _gap(P, base, v):
    """Vector from vertex v to its base position, and its squared length."""
    x, y, z = base[v, 0] - P[v, 0], base[v, 1] - P[v, 1], base[v, 2] - P[v, 2]
    return x, y, z, x * x + y * y + z * z


@compiled
def _failed_before(rings, region, v):
    """Whether base vertex v could not return before, and nothing round it moved since."""
    last = region.times.base[v]
    for k in range(rings.at[0, v], rings.at[0, v + 1]):
        if region.times.moved[rings.around[k]] >= last:
            return False
    return last > 0


@compiled
def _traced(surface, points, base, v, region):
    """The face of the point that traces from v towards its base position end in; its barycentrics are in region.search.tried, and
    v is there."""
    w = region.search.tried
    for _ in range(STEPS):
        x, y, z, _ = _gap(points.P, base, v)
        w[0], w[1], w[2] = points.b[v, 0], points.b[v, 1], points.b[v, 2]
        g = trace_geodesic(surface, points.face[v], w, x, y, z)
        move_point(surface, points, v, g, w)
    w[0], w[1], w[2] = points.b[v, 0], points.b[v, 1], points.b[v, 2]
    return points.face[v]


@compiled
def return_to_base_positions(surface, rings, points, base, first, last, region):
    """Move those of the base vertices first..last - 1 that are far from their positions base (n0, 3) towards them; returns how
    many moved."""
    P, done = points.P, 0
    for v in range(first, min(last, len(base))):
        if rings.at[0, v] == rings.at[0, v + 1]:
            continue
        gap = _gap(P, base, v)[3]
        o = rings.around[rings.at[0, v]]
        side = (P[o, 0] - P[v, 0]) ** 2 + (P[o, 1] - P[v, 1]) ** 2 + (P[o, 2] - P[v, 2]) ** 2
        if gap < FAR * FAR * side or _failed_before(rings, region, v):
            continue
        region.state[TIME] += 1
        region.times.base[v] = region.state[TIME]
        begin(region)
        count = add(v, region, 0)
        save(points, region, 1)
        g = _traced(surface, points, base, v, region)
        far = _gap(P, base, v)[3] > NEARER * NEARER * gap
        restore(points, region, 1)
        count = 0 if far else gather(rings, -1, region, count)
        if count == 0:
            continue
        save(points, region, count)
        before = fitness(rings, points, region)
        move_point(surface, points, v, g, region.search.tried)
        _, complete = propagate(surface, rings, points, -1, region, before.flipped)
        if complete and better(rings, points, region, before, before.flipped, 1.0, 1.0):
            commit(region, count)
            done += 1
        else:
            restore(points, region, count)
    return done
