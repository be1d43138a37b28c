"""Base vertices whose point of the map lies far from them walk home: towards their own place, the finer ones follow.

Where faces are long and flat, as in models of machine parts, the flattenings of many collapses push the point of a base
vertex along the surface, and all faces round it with it. Kept is what turns no more faces and is no worse otherwise
(see `patch.better`).
"""
from .jit import compiled
from .patch import add, better, carry, faces_round, fitness, settled, swap
from .walk import move, walk

FAR = 0.1  # distance from home, in lengths of an edge of level 1, from which on a vertex walks
STEPS = 4  # walks, each straight at home
NEARER = 0.7  # share of the distance that may be left


@compiled
def _gap(P, home, v):
    """Vector from vertex v to its home, and its squared length."""
    x, y, z = home[v, 0] - P[v, 0], home[v, 1] - P[v, 1], home[v, 2] - P[v, 2]
    return x, y, z, x * x + y * y + z * z


@compiled
def go_home(surface, rings, points, home, first, last, patch):
    """Let the base vertices first..last - 1 walk to home (n0, 3); returns how many did."""
    P, w, done = points.P, patch.w, 0
    for v in range(first, min(last, len(home))):
        h = rings.out[0, v]
        if rings.fixed[v] or h < 0:
            continue
        gap = _gap(P, home, v)[3]
        o = rings.F[h // 3, (h + 1) % 3]
        side = (P[o, 0] - P[v, 0]) ** 2 + (P[o, 1] - P[v, 1]) ** 2 + (P[o, 2] - P[v, 2]) ** 2
        if gap < FAR * FAR * side:
            continue
        patch.state[0] += 1
        count = add(points, v, patch, 0)
        for _ in range(STEPS):
            x, y, z, _ = _gap(P, home, v)
            w[0], w[1], w[2] = points.b[v, 0], points.b[v, 1], points.b[v, 2]
            g = walk(surface, points.face[v], w, x, y, z)
            move(surface, points, v, g, w)
        if _gap(P, home, v)[3] > NEARER * NEARER * gap:
            swap(surface, points, patch, count)
            continue
        count = carry(surface, rings, points, -1, patch, count)
        faces = faces_round(rings, patch, count)
        swap(surface, points, patch, count)
        before = fitness(rings, points, patch, faces)
        swap(surface, points, patch, count)
        fits = 0 <= faces and count < len(patch.vertices)
        if fits and better(rings, points, patch, faces, before, before[0], 1.0, 1.0):
            settled(patch, count)
            done += 1
        else:
            swap(surface, points, patch, count)
    return done
