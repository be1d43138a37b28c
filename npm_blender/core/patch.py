"""Several vertices of the levels moved at once, on trial: what moved, what lies round it, whether that is better.

A trial moves some vertices of one level; the finer vertices round them follow to the middles of their edges (see
`carry`), or a coarse face could never turn upright without folding its own subdivision. A trial is kept if it is better
(see `better`), else everything goes back to where it was.
"""
from typing import NamedTuple

import numpy as np

from .jit import compiled
from .unfold import MARGIN, bulge, cosine, projected
from .walk import move, show, walk

_VERTICES, _FACES = 24, 64  # room for vertices and faces of a patch, times 4^L


class Patch(NamedTuple):
    """Work space: w (3,), best (4,), where (4,) of `improve`; the vertices and faces of a patch, and what is kept of the
    vertices (face and barycentrics); marks of all vertices and faces; when a vertex last moved, and when single steps last
    failed at a face; state (4,): last mark, random state, vertices that trials may still move, the time that moved and
    failed count in."""

    w: np.ndarray
    best: np.ndarray
    where: np.ndarray
    vertices: np.ndarray
    faces: np.ndarray
    kept: np.ndarray
    mark: np.ndarray
    seen: np.ndarray
    moved: np.ndarray
    failed: np.ndarray
    state: np.ndarray

    @staticmethod
    def make(vertices: int, faces: int, levels: int, work: int) -> "Patch":
        """Work space for that many points and faces in all, levels; work: vertices that trials may move."""
        room = _VERTICES * 4**levels
        return Patch(np.zeros(3), np.zeros(4), np.zeros(4), np.zeros(room, np.int64), np.zeros(_FACES * 4**levels, np.int64),
                     np.zeros((room, 4)), np.zeros(vertices, np.int64), np.zeros(faces, np.int64),
                     np.zeros(vertices, np.int64), np.zeros(faces, np.int64), np.array([0, 1, work, 0]))


@compiled
def changed(rings, f, patch):
    """Whether anything round face f moved since single steps failed at it: if not, they would fail again."""
    last = patch.failed[f]
    if last == 0:
        return True
    for c in range(3):
        v = rings.F[f, c]
        if patch.moved[v] >= last:
            return True
        for level in range(0 if rings.fixed[v] else len(rings.out)):
            h = start = rings.out[level, v]
            while h >= 0:
                if patch.moved[rings.F[h // 3, (h + 1) % 3]] >= last:
                    return True
                h = rings.opposite[h + 2 if h % 3 == 0 else h - 1]
                if h == start:
                    break
    return False


@compiled
def add(points, v, patch, count):
    """Make v, which has not moved yet, one of the patch's vertices; returns the new count."""
    patch.mark[v] = patch.state[0]
    patch.vertices[count] = v
    kept = patch.kept
    kept[count, 0], kept[count, 1], kept[count, 2] = points.b[v, 0], points.b[v, 1], points.b[v, 2]
    kept[count, 3] = points.face[v]
    return count + 1


@compiled
def add_neighbours(rings, points, level, v, patch, count):
    """Add the free neighbours of v at a level; returns the new count, that of the room if it does not suffice."""
    h = start = rings.out[level, v]
    while h >= 0:
        x = rings.F[h // 3, (h + 1) % 3]
        if patch.mark[x] != patch.state[0] and not rings.fixed[x]:
            if count == len(patch.vertices):
                return count
            count = add(points, x, patch, count)
        h = rings.opposite[h + 2 if h % 3 == 0 else h - 1]
        if h == start:
            break
    return count


@compiled
def faces_round(rings, patch, count):
    """Collect the faces of all levels round the patch's vertices; returns their number, -1 if there is no room."""
    found = 0
    for i in range(count):
        for level in range(len(rings.out)):
            h = start = rings.out[level, patch.vertices[i]]
            while h >= 0:
                f = h // 3
                if patch.seen[f] != patch.state[0]:
                    if found == len(patch.faces):
                        return -1
                    patch.seen[f] = patch.state[0]
                    patch.faces[found] = f
                    found += 1
                h = rings.opposite[h + 2 if h % 3 == 0 else h - 1]
                if h == start:
                    break
    return found


@compiled
def turned(rings, points, patch, count):
    """How many of the patch's faces are turned."""
    out = 0
    for i in range(count):
        out += cosine(rings.F, points.P, points.N, patch.faces[i]) <= MARGIN
    return out


@compiled
def fitness(rings, points, patch, count):
    """Of the patch's faces: how many are turned; and of the finest ones the summed bulge, and the summed area projected on
    the surface, from which turned faces take away (times 6)."""
    height = area = 0.0
    for i in range(count):
        f = patch.faces[i]
        if f >= rings.first[len(rings.out) - 1]:
            height += bulge(rings.F, points.P, points.N, f)
            area += projected(rings.F, points.P, points.N, f)
    return turned(rings, points, patch, count), height, area


@compiled
def better(rings, points, patch, count, before, most, farther, covered):
    """Whether at most `most` of the patch's faces are turned; there may be `farther` times the bulge of `before`, and must
    be `covered` times the area."""
    after = fitness(rings, points, patch, count)
    return after[0] <= most and after[1] <= farther * before[1] + 1e-15 and after[2] >= covered * before[2]


@compiled
def swap(surface, points, patch, count):
    """Put the patch's vertices back where they were, and keep where they are."""
    for i in range(count):
        v, g = patch.vertices[i], patch.kept[i, 3]
        b0, b1, b2, f = points.b[v, 0], points.b[v, 1], points.b[v, 2], points.face[v]
        move(surface, points, v, int(g), patch.kept[i])
        patch.kept[i, 0], patch.kept[i, 1], patch.kept[i, 2], patch.kept[i, 3] = b0, b1, b2, f


@compiled
def settled(patch, count):
    """Note that the patch's vertices moved for good."""
    patch.state[3] += 1
    for i in range(count):
        patch.moved[patch.vertices[i]] = patch.state[3]


@compiled
def halve(surface, points, v, i, j, w, u):
    """Put v near the middle between i and j: the best of three walks, from its own place and from theirs."""
    P = points.P
    mx, my, mz = (P[i, 0] + P[j, 0]) / 2, (P[i, 1] + P[j, 1]) / 2, (P[i, 2] + P[j, 2]) / 2
    nearest, face = np.inf, -1
    show(surface, points, v, points.face[v], points.b[v])
    ox, oy, oz = P[v, 0], P[v, 1], P[v, 2]
    for trial in range(3):
        o = v if trial == 0 else (i if trial == 1 else j)
        w[0], w[1], w[2] = points.b[o, 0], points.b[o, 1], points.b[o, 2]
        x, y, z = mx - ox, my - oy, mz - oz
        if trial > 0:
            x, y, z = mx - P[o, 0], my - P[o, 1], mz - P[o, 2]
        g = walk(surface, points.face[o], w, x, y, z)
        show(surface, points, v, g, w)
        gap = (P[v, 0] - mx) ** 2 + (P[v, 1] - my) ** 2 + (P[v, 2] - mz) ** 2
        if gap < nearest:
            nearest, face = gap, g
            u[0], u[1], u[2] = w[0], w[1], w[2]
    move(surface, points, v, face, u)


@compiled
def carry(surface, rings, points, level, patch, count):
    """Put the finer vertices round the patch's, which are of a level (-1: of the base), on the middles of their edges.

    Returns the new count, that of the room if it does not suffice.
    """
    for k in range(level + 1, len(rings.out)):
        old = count
        for i in range(old):
            if patch.vertices[i] < rings.n[k]:
                count = add_neighbours(rings, points, k, patch.vertices[i], patch, count)
        for i in range(old, count):
            v = patch.vertices[i]
            a = b = -1
            h = start = rings.out[k, v]
            while True:
                o = rings.F[h // 3, (h + 1) % 3]
                if o < rings.n[k]:
                    a, b = b, o
                h = rings.opposite[h + 2 if h % 3 == 0 else h - 1]
                if h == start:
                    break
            halve(surface, points, v, a, b, patch.w, patch.where)
    return count
