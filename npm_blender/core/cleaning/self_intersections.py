"""Faces that pass through other faces, counted on a sample: they do no harm to compression, but artists want to know."""
import numpy as np

from ..geometry import BVH_STACK, build_bvh
from ..jit import compiled
from ..progress import Progress, no_progress

SAMPLE = 20_000  # faces that are tested against all others
SLICE = 1000  # of them are tested between two calls of `progress`
TINY = 1e-15  # volume of a tetrahedron in the unit frame that is rounding
DEEP = 1e-5  # of the box: how far an edge has to reach to both sides of the face that it passes through
WORK = 100  # box tests for each of them on average; more are needed where many faces lie on each other


def crossing_faces(V: np.ndarray, F: np.ndarray, progress: Progress = no_progress) -> tuple[int, bool]:
    """About how many faces of F (m, 3) an edge of another face passes through, or an own edge through another.

    Returns the count and whether it is exact; otherwise it is scaled up from an even sample of SAMPLE faces. Faces
    that have a vertex in common, that touch, or that lie in one plane do not count, nor do passages less than DEEP.
    Of faces that lie on each other by the thousand, fewer are tested. Raises what `progress` raises.
    """
    asked = np.arange(len(F)) if len(F) <= SAMPLE else (np.arange(SAMPLE) * (len(F) / SAMPLE)).astype(np.int64)
    centre, size = (V.min(0) + V.max(0)) / 2, max(float(np.ptp(V, axis=0).max()), 1e-300)
    corners = ((V - centre) / size)[F].reshape(-1, 9)
    nodes, links, order = build_bvh(corners)
    rows, F, asked = corners[order], np.ascontiguousarray(F[order]), np.argsort(order)[asked]
    found, tested, work = 0, 0, WORK * len(asked)
    for i in range(0, len(asked), SLICE):
        progress(i / len(asked), "Looking for faces that pass through others")
        crossing, done, work = _crossing(rows, F, asked[i:i + SLICE], nodes, links, work)
        found, tested = found + crossing, tested + done
        if work < 0:
            break
    if tested == len(F):
        return int(found), True
    return int(np.ceil(found * (len(F) / max(tested, 1)))), False


@compiled
def _side(a, b, c, p):
    """Six times the volume of the tetrahedron of three points a, b, c (3,) and p (3,)."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    wx, wy, wz = p[0] - a[0], p[1] - a[1], p[2] - a[2]
    return (uy * vz - uz * vy) * wx + (uz * vx - ux * vz) * wy + (ux * vy - uy * vx) * wz


@compiled
def _pierces(a, b, t):
    """Does the segment a-b pass through the inside of the triangle t (9,)?"""
    p, q, r = t[:3], t[3:6], t[6:9]
    s0, s1 = _side(p, q, r, a), _side(p, q, r, b)
    if s0 * s1 >= 0:
        return False
    u, v, w = _side(a, b, p, q), _side(a, b, q, r), _side(a, b, r, p)
    if not ((u > TINY and v > TINY and w > TINY) or (u < -TINY and v < -TINY and w < -TINY)):
        return False
    ux, uy, uz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    vx, vy, vz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return min(abs(s0), abs(s1)) > DEEP * np.sqrt(x * x + y * y + z * z)


@compiled
def _cross(s, t):
    for k in range(3):
        i, j = 3 * k, 3 * ((k + 1) % 3)
        if _pierces(s[i:i + 3], s[j:j + 3], t) or _pierces(t[i:i + 3], t[j:j + 3], s):
            return True
    return False


@compiled(allocates=True)
def _crossing(corners, F, asked, nodes, links, work):
    """Faces (in leaf order) among `asked` that cross another, how many were tested, and the work that is left."""
    found, tested = 0, 0
    stack = np.zeros(BVH_STACK, np.int32)
    box = np.zeros(6)
    for f in asked:
        if work < 0:
            break
        tested += 1
        t = corners[f]
        for x in range(3):
            box[x], box[3 + x] = min(t[x], t[3 + x], t[6 + x]), max(t[x], t[3 + x], t[6 + x])
        top, stack[0] = 1, 0
        crosses = False
        while top and not crosses:
            top -= 1
            work -= 1
            node = nodes[stack[top]]
            first, count = links[stack[top], 0], links[stack[top], 1]
            if (node[0] > box[3] or node[1] > box[4] or node[2] > box[5]
                    or node[3] < box[0] or node[4] < box[1] or node[5] < box[2]):
                continue
            if count == 0:
                stack[top], stack[top + 1] = first, first + 1
                top += 2
            for g in range(first, first + count):
                shared = False
                for i in range(3):
                    for j in range(3):
                        shared = shared or F[f, i] == F[g, j]
                work -= 1
                if not shared and _cross(t, corners[g]):
                    crosses = True
                    break
        found += crosses
    return found, tested, work
