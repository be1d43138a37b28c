"""A turned face that no single step mends: its surroundings are smoothed, or thrown about at random, and mended again.

Kept is what leaves fewer turned faces, over all levels, and is no worse otherwise (see `patch.better`); else everything
goes back to where it was. The random steps are seeded, so the result is the same on every run.
"""
import numpy as np

from .jit import compiled
from .patch import add, add_neighbours, better, carry, faces_round, fitness, settled, swap, turned
from .unfold import FARTHER, MARGIN, cosine, improve, middle
from .walk import move, walk

SMOOTHED = 4  # trials that smooth, each with one more ring of vertices
SMOOTH = 2  # steps of smoothing
LEAST = 0.15  # random step of the first trial, in mean lengths of the face's sides; of the last: 1
SWEEPS = 4


@compiled
def _size(F, P, f):
    """Root of the mean squared side of face f."""
    total = 0.0
    for c in range(3):
        i, j = F[f, c], F[f, (c + 1) % 3]
        total += (P[i, 0] - P[j, 0]) ** 2 + (P[i, 1] - P[j, 1]) ** 2 + (P[i, 2] - P[j, 2]) ** 2
    return np.sqrt(total / 3)


@compiled
def _throw(surface, points, v, size, patch):
    """Walk v by up to `size` in each coordinate."""
    w, s = patch.w, patch.state
    for c in range(3):
        s[1] = s[1] * 6364136223846793005 + 1442695040888963407
        patch.where[c] = size * (((s[1] >> 33) & 0xFFFFF) / 524288.0 - 1.0)
    w[0], w[1], w[2] = points.b[v, 0], points.b[v, 1], points.b[v, 2]
    g = walk(surface, points.face[v], w, patch.where[0], patch.where[1], patch.where[2])
    move(surface, points, v, g, w)


@compiled
def _smooth(surface, rings, points, level, patch, count):
    """Walk the patch's vertices towards the middles of their rings of a level, some times."""
    w = patch.w
    for _ in range(SMOOTH):
        for i in range(count):
            v = patch.vertices[i]
            x, y, z = middle(rings, points.P, v, level)
            w[0], w[1], w[2] = points.b[v, 0], points.b[v, 1], points.b[v, 2]
            g = walk(surface, points.face[v], w, x - points.P[v, 0], y - points.P[v, 1], z - points.P[v, 2])
            move(surface, points, v, g, w)


@compiled
def _mend(surface, rings, points, levels, faces, before, patch, covered):
    """Improve marked corners of turned faces among the patch's; returns how many faces stay turned."""
    after = turned(rings, points, patch, faces)
    for _ in range(SWEEPS):
        if after == 0 or after > 3 * before + 6:
            break
        moved = False
        for k in range(faces):
            f = patch.faces[k]
            level = 0
            while f >= rings.first[level + 1]:
                level += 1
            for c in range(3):
                if cosine(rings.F, points.P, points.N, f) > MARGIN:
                    break
                if patch.mark[rings.F[f, c]] == patch.state[0]:
                    moved |= improve(surface, rings, points, f, c, level, levels, patch.w, patch.best, patch.where,
                                     after <= before, covered)
        after = turned(rings, points, patch, faces)
        if not moved:
            break
    return after


@compiled
def shake(surface, rings, points, f, level, levels, trials, patch, covered):
    """Smooth round face f of a level, then shake its corners, and every other time their rings, up to `trials` times.

    True if that left fewer turned faces; the faces round them keep `covered` of their projected area.
    """
    for trial in range(trials):
        if patch.state[2] <= 0:
            break
        patch.state[0] += 1
        count = 0
        for c in range(3):
            if not rings.fixed[rings.F[f, c]]:
                count = add(points, rings.F[f, c], patch, count)
        for _ in range(trial if trial < SMOOTHED else trial % 2):
            for i in range(count):
                count = add_neighbours(rings, points, level, patch.vertices[i], patch, count)
        if trial < SMOOTHED:
            _smooth(surface, rings, points, level, patch, count)
        else:
            size = _size(rings.F, points.P, f) * (LEAST + (1.0 - LEAST) * trial / trials)
            for i in range(count):
                _throw(surface, points, patch.vertices[i], size, patch)
        count = carry(surface, rings, points, level, patch, count)
        patch.state[2] -= count
        faces = faces_round(rings, patch, count)
        swap(surface, points, patch, count)
        before = fitness(rings, points, patch, faces)
        swap(surface, points, patch, count)
        _mend(surface, rings, points, levels, faces, before[0], patch, covered)
        fits = 0 <= faces and count < len(patch.vertices)
        if fits and better(rings, points, patch, faces, before, before[0] - 1, FARTHER, covered):
            settled(patch, count)
            return True
        swap(surface, points, patch, count)
    return False
