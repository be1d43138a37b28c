"""Base vertices whose point of the map lies far from them walk home: towards their own place, the finer ones follow.

Where faces are long and flat, as in models of machine parts, the flattenings of many collapses push the point of a base
vertex along the surface, and all faces round it with it. Kept is what turns no more faces and is no worse otherwise
(see `patch.better`).
"""
from ..geometry import put_at, trace_geodesic
from ..jit import compiled
from .propagation import propagate
from .trial import add, better, commit, fitness, gather, restore, save

FAR = 0.1  # distance from home, in lengths of an edge of level 1, from which on a vertex walks
STEPS = 4  # walks, each straight at home
NEARER = 0.7  # share of the distance that may be left


@compiled
def _gap(P, home, v):
    """Vector from vertex v to its home, and its squared length."""
    x, y, z = home[v, 0] - P[v, 0], home[v, 1] - P[v, 1], home[v, 2] - P[v, 2]
    return x, y, z, x * x + y * y + z * z


@compiled
def _stuck(rings, patch, v):
    """Whether base vertex v failed to walk home, and nothing round it moved since."""
    last = patch.stuck[v]
    for k in range(rings.at[0, v], rings.at[0, v + 1]):
        if patch.moved[rings.around[k]] >= last:
            return False
    return last > 0


@compiled
def return_to_base_positions(surface, rings, points, home, first, last, patch):
    """Let the base vertices first..last - 1 walk to home (n0, 3); returns how many did."""
    P, w, done = points.P, patch.w, 0
    for v in range(first, min(last, len(home))):
        if rings.at[0, v] == rings.at[0, v + 1]:
            continue
        gap = _gap(P, home, v)[3]
        o = rings.around[rings.at[0, v]]
        side = (P[o, 0] - P[v, 0]) ** 2 + (P[o, 1] - P[v, 1]) ** 2 + (P[o, 2] - P[v, 2]) ** 2
        if gap < FAR * FAR * side or _stuck(rings, patch, v):
            continue
        patch.state[3] += 1
        patch.stuck[v] = patch.state[3]
        patch.state[0] += 1
        patch.vertices[0], patch.mark[v] = v, patch.state[0]
        save(points, patch, 1)
        for _ in range(STEPS):
            x, y, z, _ = _gap(P, home, v)
            w[0], w[1], w[2] = points.b[v, 0], points.b[v, 1], points.b[v, 2]
            g = trace_geodesic(surface, points.face[v], w, x, y, z)
            put_at(surface, points, v, g, w)
        far = _gap(P, home, v)[3] > NEARER * NEARER * gap
        g, w[0], w[1], w[2] = points.face[v], points.b[v, 0], points.b[v, 1], points.b[v, 2]
        restore(points, patch, 1)
        count = 0 if far else gather(rings, -1, patch, add(v, patch, 0))
        if count == 0:
            continue
        save(points, patch, count)
        before = fitness(rings, points, patch)
        put_at(surface, points, v, g, w)
        _, all_carried = propagate(surface, rings, points, -1, patch, before[0])
        if all_carried and better(rings, points, patch, before, before[0], 1.0, 1.0):
            commit(patch, count)
            done += 1
        else:
            restore(points, patch, count)
    return done
