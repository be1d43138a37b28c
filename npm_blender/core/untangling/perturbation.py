"""A turned face that no single step mends: its surroundings are smoothed, or thrown about at random, and mended again.

Kept is what leaves fewer turned faces, over all levels, and is no worse otherwise (see `patch.better`); else everything
goes back to where it was. The random steps are seeded, so the result is the same on every run.
"""
import numpy as np

from ..geometry import is_flipped, put_at, trace_geodesic
from ..jit import compiled
from .propagation import propagate
from .trial import SMOOTHED, add, add_neighbours, better, changed, fitness, gather, restore, save, turned
from .vertex_moves import FARTHER, middle, relocate_vertex

SMOOTH = 2  # steps of smoothing
LEAST = 0.15  # random step of the first trial, in mean lengths of the face's sides; of the last: 1
SWEEPS = 4
WORSE, WORSE_OF = 10, 16  # so many turned faces more than before, or one in so many of the patch's, are not mended
STEP = 5  # work of improving a vertex, in vertices moved


@compiled
def _size(F, P, f):
    """Root of the mean squared side of face f."""
    total = 0.0
    for c in range(3):
        i, j = F[f, c], F[f, (c + 1) % 3]
        total += (P[i, 0] - P[j, 0]) ** 2 + (P[i, 1] - P[j, 1]) ** 2 + (P[i, 2] - P[j, 2]) ** 2
    return np.sqrt(total / 3)


@compiled
def _perturb(surface, points, v, size, patch):
    """Walk v by up to `size` in each coordinate."""
    w, s = patch.w, patch.state
    for c in range(3):
        s[1] = s[1] * 6364136223846793005 + 1442695040888963407
        patch.where[c] = size * (((s[1] >> 33) & 0xFFFFF) / 524288.0 - 1.0)
    w[0], w[1], w[2] = points.b[v, 0], points.b[v, 1], points.b[v, 2]
    g = trace_geodesic(surface, points.face[v], w, patch.where[0], patch.where[1], patch.where[2])
    put_at(surface, points, v, g, w)


@compiled
def _smooth(surface, rings, points, level, patch, count):
    """Walk the patch's first vertices towards the middles of their rings of a level, some times."""
    w = patch.w
    for _ in range(SMOOTH):
        for i in range(count):
            v = patch.vertices[i]
            x, y, z = middle(rings, points.P, v, level)
            w[0], w[1], w[2] = points.b[v, 0], points.b[v, 1], points.b[v, 2]
            g = trace_geodesic(surface, points.face[v], w, x - points.P[v, 0], y - points.P[v, 1], z - points.P[v, 2])
            put_at(surface, points, v, g, w)


@compiled
def mend(surface, rings, points, f, level, patch, within, moved, time, thorough, covered):
    """Improve the free corners of face f of a level while it is turned; within: only those of the patch.

    True if one moved, whose time is noted in moved (n,).
    """
    found = False
    for c in range(3):
        v = rings.F[f, c]
        if not is_flipped(rings.F, points.P, points.N, f):
            break
        if not rings.fixed[v] and (not within or patch.mark[v] == patch.state[0]):
            patch.state[2] -= STEP
            if relocate_vertex(surface, rings, points, f, c, level, len(rings.at), patch.w, patch.best, patch.where,
                               thorough, covered):
                moved[v] = time
                found = True
    return found


@compiled
def _turned(rings, points, patch):
    """How many of the patch's faces are turned."""
    faces = patch.faces_to[len(rings.at) - 1]
    return turned(rings, points, patch, 0, faces, faces)


@compiled
def _mend_all(surface, rings, points, before, most, patch, covered):
    """Improve corners of the patch's turned faces, `before` of which were turned before the trial; above `most` there is no hope.

    What failed is tried again only when something moved round it.
    """
    levels, state = len(rings.at), patch.state
    faces = patch.faces_to[levels - 1]
    after = _turned(rings, points, patch)
    thorough, begun = False, 0
    for _ in range(SWEEPS):
        if after == 0 or after > most:
            break
        if begun == 0 or thorough != (after <= before):  # what failed at less may do now
            thorough = after <= before
            state[4] += 1
            begun = state[4]
        moved, level = False, 0
        for k in range(faces):
            f = patch.faces[k]
            while k >= patch.faces_to[level]:
                level += 1
            if not is_flipped(rings.F, points.P, points.N, f):
                continue
            if patch.failed_now[f] >= begun and not changed(rings, f, patch.failed_now[f], patch.moved_now):
                continue
            state[4] += 1
            patch.failed_now[f] = state[4]
            moved |= mend(surface, rings, points, f, level, patch, True, patch.moved_now, state[4], thorough, covered)
        after = _turned(rings, points, patch)
        if not moved:
            break


@compiled
def _gather_round(rings, f, level, width, patch):
    """The patch of the free corners of face f of a level and `width` rings round them.

    Returns how many of its vertices are of that level, and how many there are in all (0: no room).
    """
    patch.state[0] += 1
    count = 0
    for c in range(3):
        if not rings.fixed[rings.F[f, c]]:
            count = add(rings.F[f, c], patch, count)
    for _ in range(width):
        for i in range(count):
            count = add_neighbours(rings, level, patch.vertices[i], patch, count)
    return count, gather(rings, level, patch, count)


@compiled
def _same(rings, patch, since):
    """Whether no corner of the patch's faces moved since that time (0: never looked at)."""
    if since == 0:
        return False
    for i in range(patch.faces_to[len(rings.at) - 1]):
        for c in range(3):
            if patch.moved[rings.F[patch.faces[i], c]] >= since:
                return False
    return True


@compiled
def _shake(surface, rings, points, f, level, trials, patch, covered, own, workers, earlier, won, costs, failed):
    """Smooth and shake the corners of face f of a level, then these with one ring round them, up to `trials` times in all,
    then smooth with two and three rings: what costs least comes first. Smoothing that left as many turned faces is not tried
    again before something round it moved. Stops where that left fewer turned faces, and the faces round them keep `covered` of
    their projected area.

    Of these tries this makes number own, own + workers, ...; each is seeded by its number, and starts from what is there now.
    See `shake_all` for won, of whose tries `earlier` come before those of this face. costs (t,) gets the work of each try;
    failed (SMOOTHED,) whether smoothing with so many rings left as many turned faces.
    Returns the number that succeeded, or -1, and how many vertices of its patch moved.
    """
    work, number = patch.state[2], 0
    for width in range(SMOOTHED):
        free, count = _gather_round(rings, f, level, width, patch)
        if count == 0:
            break
        smooth = not _same(rings, patch, patch.smoothed[f, width])
        if not smooth and width >= 2:
            continue
        save(points, patch, count)
        before = fitness(rings, points, patch)
        most = before[0] + max(WORSE, patch.faces_to[len(rings.at) - 1] // WORSE_OF)
        for trial in range(trials if width < 2 else 1):
            if not smooth if trial == 0 else trial < SMOOTHED or trial % 2 != width:
                continue
            number += 1
            if (number - 1) % workers != own:
                continue
            if earlier + number - 1 > won[0]:
                return -1, 0
            patch.state[1] = (f * 1_000_003 + trials * 8191 + number) * 6364136223846793005 + 1442695040888963407
            if trial == 0:
                _smooth(surface, rings, points, level, patch, free)
            else:
                size = _size(rings.F, points.P, f) * (LEAST + (1.0 - LEAST) * trial / trials)
                for i in range(free):
                    _perturb(surface, points, patch.vertices[i], size, patch)
            carried, promising = propagate(surface, rings, points, level, patch, most)
            good = False
            if promising:
                _mend_all(surface, rings, points, before[0], most, patch, covered)
                good = better(rings, points, patch, before, before[0] - 1, FARTHER, covered)
            costs[number - 1] = free + carried + work - patch.state[2]
            patch.state[2] = work
            if good:
                won[0] = min(won[0], earlier + number - 1)
                return number - 1, count
            if trial == 0:
                failed[width] = not promising or _turned(rings, points, patch) >= before[0]
            restore(points, patch, count)
    return -1, 0


@compiled
def shake_all(surface, rings, points, faces, trials, patch, covered, own, workers, won, costs, failed):
    """Shake the faces (k,) that are turned (see `_shake`), up to the first that gets better.

    Of the tries, numbered by face and then within it, this makes every `workers`-th from `own` on. won (1,): the least number,
    of a face times t and within it, that any worker has succeeded with so far: it is not worth going on past that. costs (k, t)
    and failed (k, SMOOTHED): see `_shake`; a face has fewer than t tries.
    Returns the number that succeeded, or -1, and how many vertices of its patch moved.
    """
    room, level = costs.shape[1], 0
    for k in range(len(faces)):
        f = faces[k]
        if k * room > won[0]:
            break
        if not is_flipped(rings.F, points.P, points.N, f):
            continue
        while f >= rings.first[level + 1]:
            level += 1
        found, count = _shake(surface, rings, points, f, level, trials, patch, covered, own, workers, k * room, won, costs[k],
                              failed[k])
        if found >= 0:
            return k * room + found, count
    return -1, 0
