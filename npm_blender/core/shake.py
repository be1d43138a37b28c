"""A turned face that no single step mends: its surroundings are thrown about at random and mended again.

Kept is what leaves fewer turned faces, over all levels so far; else everything goes back to where it was. The random
steps are seeded, so the result is the same on every run.
"""
from typing import NamedTuple

import numpy as np

from .jit import compiled
from .unfold import FARTHER, MARGIN, bulge, cosine, improve
from .walk import move, walk

LEAST = 0.15  # random step of the first trial, in mean lengths of the face's sides; of the last: 1
SWEEPS = 4
_MOVED, _FACES = 64, 600  # vertices that one trial moves, faces round them


class Work(NamedTuple):
    """Work space: w (3,), best (3,), where (4,) of `improve`; vertices and faces of one trial, what is kept of them;
    marks of vertices and faces; when a vertex last moved, and when single steps last failed at a face; state (4,): last
    mark, random state, trials left, the time that moved and tried count in."""

    w: np.ndarray
    best: np.ndarray
    where: np.ndarray
    some: np.ndarray
    faces: np.ndarray
    keep: np.ndarray
    mark: np.ndarray
    seen: np.ndarray
    moved: np.ndarray
    tried: np.ndarray
    state: np.ndarray

    @staticmethod
    def make(vertices: int, faces: int) -> "Work":
        """Work space for that many vertices and faces in all."""
        return Work(np.zeros(3), np.zeros(3), np.zeros(4), np.zeros(_MOVED, np.int64), np.zeros(_FACES, np.int64),
                    np.zeros((_MOVED, 4)), np.zeros(vertices, np.int64), np.zeros(faces, np.int64),
                    np.zeros(vertices, np.int64), np.zeros(faces, np.int64), np.array([0, 1, 0, 0]))


@compiled
def changed(rings, f, work):
    """Whether anything round face f moved since single steps failed at it: if not, they would fail again."""
    last = work.tried[f]
    if last == 0:
        return True
    for c in range(3):
        v = rings.F[f, c]
        if work.moved[v] >= last:
            return True
        for level in range(len(rings.out)):
            h = start = rings.out[level, v]
            if h < 0:
                continue
            while True:
                if work.moved[rings.F[h // 3, (h + 1) % 3]] >= last:
                    return True
                h = rings.opposite[h + 2 if h % 3 == 0 else h - 1]
                if h == start:
                    break
    return False


@compiled
def _around(rings, level, v, vertices, mark, stamp, out, count):
    """Add to out[count:] what has no mark yet round v at a level: free neighbours, or faces; returns the new count."""
    h = start = rings.out[level, v]
    if h < 0:
        return count
    while True:
        x = rings.F[h // 3, (h + 1) % 3] if vertices else h // 3
        if mark[x] != stamp and count < len(out) and not (vertices and rings.fixed[x]):
            mark[x] = stamp
            out[count] = x
            count += 1
        h = rings.opposite[h + 2 if h % 3 == 0 else h - 1]
        if h == start:
            break
    return count


@compiled
def _turned(rings, points, faces, count):
    turned = 0
    for k in range(count):
        turned += cosine(rings.F, points.P, points.N, faces[k]) <= MARGIN
    return turned


@compiled
def _bulge(rings, points, level, faces, count):
    """Summed bulge of those faces that are of a level."""
    total = 0.0
    for k in range(count):
        if rings.first[level] <= faces[k] < rings.first[level + 1]:
            total += bulge(rings.F, points.P, points.N, faces[k])
    return total


@compiled
def _size(F, P, f):
    """Root of the mean squared side of face f."""
    total = 0.0
    for c in range(3):
        i, j = F[f, c], F[f, (c + 1) % 3]
        total += (P[i, 0] - P[j, 0]) ** 2 + (P[i, 1] - P[j, 1]) ** 2 + (P[i, 2] - P[j, 2]) ** 2
    return np.sqrt(total / 3)


@compiled
def _throw(surface, points, v, size, work):
    """Walk v by up to `size` in each coordinate."""
    w, s = work.w, work.state
    for c in range(3):
        s[1] = s[1] * 6364136223846793005 + 1442695040888963407
        work.where[c] = size * (((s[1] >> 33) & 0xFFFFF) / 524288.0 - 1.0)
    w[0], w[1], w[2] = points.b[v, 0], points.b[v, 1], points.b[v, 2]
    g = walk(surface, points.face[v], w, work.where[0], work.where[1], work.where[2])
    move(surface, points, v, g, w)


@compiled
def _mend(surface, rings, points, levels, stars, before, work):
    """Improve marked corners of turned faces among work.faces[:stars]; returns how many faces stay turned."""
    after = _turned(rings, points, work.faces, stars)
    for _ in range(SWEEPS):
        if after == 0 or after > 3 * before + 6:
            break
        moved = False
        for k in range(stars):
            f = work.faces[k]
            level = 0
            while f >= rings.first[level + 1]:
                level += 1
            for c in range(3):
                if cosine(rings.F, points.P, points.N, f) > MARGIN:
                    break
                if work.mark[rings.F[f, c]] == work.state[0]:
                    moved |= improve(surface, rings, points, f, c, level, levels, work.w, work.best, work.where,
                                     after <= before)
        after = _turned(rings, points, work.faces, stars)
        if not moved:
            break
    return after


@compiled
def shake(surface, rings, points, f, level, levels, trials, work):
    """Shake the corners of face f of a level, and every other time their rings; True if that left fewer turned faces."""
    for trial in range(trials):
        if work.state[2] <= 0:
            break
        work.state[2] -= 1
        work.state[0] += 1
        stamp = work.state[0]
        count = 0
        for c in range(3):
            v = rings.F[f, c]
            if not rings.fixed[v]:
                work.mark[v] = stamp
                work.some[count] = v
                count += 1
        if trial % 2:
            for k in range(count):
                count = _around(rings, level, work.some[k], True, work.mark, stamp, work.some, count)
        stars = 0
        for k in range(count):
            for other in range(levels):
                stars = _around(rings, other, work.some[k], False, work.seen, stamp, work.faces, stars)
        before = _turned(rings, points, work.faces, stars)
        most = FARTHER * _bulge(rings, points, levels - 1, work.faces, stars)
        size = _size(rings.F, points.P, f) * (LEAST + (1.0 - LEAST) * trial / trials)
        for k in range(count):
            v = work.some[k]
            work.keep[k, 0], work.keep[k, 3] = points.b[v, 0], points.face[v]
            work.keep[k, 1], work.keep[k, 2] = points.b[v, 1], points.b[v, 2]
            _throw(surface, points, v, size, work)
        after = _mend(surface, rings, points, levels, stars, before, work)
        if after < before and _bulge(rings, points, levels - 1, work.faces, stars) <= most:
            work.state[3] += 1
            for k in range(count):
                work.moved[work.some[k]] = work.state[3]
            return True
        for k in range(count):
            move(surface, points, work.some[k], int(work.keep[k, 3]), work.keep[k])
    return False
