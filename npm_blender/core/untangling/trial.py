"""Several vertices of the levels moved at once, on trial: what moves, what lies round it, whether that is better.

A trial moves some vertices of one level; the finer vertices round them follow to the middles of their edges (see
`propagate`), or a coarse face could never turn upright without folding its own subdivision. Which vertices and faces these
are depends on connectivity alone, so a patch is gathered once for many trials. A trial is kept if it is better
(see `better`), else everything goes back to where it was.
"""
from typing import NamedTuple

import numpy as np

from ..geometry import is_flipped, not_flipped, orientation_measures
from ..jit import compiled

_VERTICES, _FACES = 24, 64  # room for vertices and faces of a patch, times 4^L
SMOOTHED = 4  # widths of a patch that is smoothed (see `shake`)
NEAR = 0.05  # distance from the middle of an edge, in its lengths, that ends the search for a place there


class TrialRegion(NamedTuple):
    """Work space: w (3,), best (4,), where (4,) of `relocate_vertex`; the vertices and faces of a patch, coarse before fine, and
    how many of them are of each level and those before it (vertices_to, faces_to); what is kept of the vertices (face,
    barycentrics, position, normal); marks of all vertices and faces; when a vertex last moved for good, and when single
    steps last failed at a face; moved_now and failed_now: the same within a trial; stuck: when a base vertex last failed
    to walk home; smoothed (m, SMOOTHED): when smoothing with so many rings last failed at a face. state (5,): last mark,
    random state, work left (vertices moved, and some more for each that single steps improve), the time that moved, failed,
    stuck and smoothed count in, that of moved_now and failed_now."""

    w: np.ndarray
    best: np.ndarray
    where: np.ndarray
    vertices: np.ndarray
    faces: np.ndarray
    vertices_to: np.ndarray
    faces_to: np.ndarray
    kept: np.ndarray
    mark: np.ndarray
    seen: np.ndarray
    moved: np.ndarray
    failed: np.ndarray
    moved_now: np.ndarray
    failed_now: np.ndarray
    stuck: np.ndarray
    smoothed: np.ndarray
    state: np.ndarray

    @staticmethod
    def make(vertices: int, faces: int, levels: int, work: int) -> "TrialRegion":
        """Work space for that many points and faces in all, levels; work: see state."""
        room = _VERTICES * 4**levels

        def zeros(*size: int) -> np.ndarray:
            return np.zeros(size, np.int64)

        return TrialRegion(np.zeros(3), np.zeros(4), np.zeros(4), zeros(room), zeros(_FACES * 4**levels), zeros(levels),
                     zeros(levels), np.zeros((room, 10)), zeros(vertices), zeros(faces), zeros(vertices), zeros(faces),
                     zeros(vertices), zeros(faces), zeros(vertices), zeros(faces, SMOOTHED), np.array([0, 1, work, 0, 0]))

    def another(self) -> "TrialRegion":
        """Work space for another thread, with the same times of what moved or failed for good."""
        own = ("w", "best", "where", "vertices", "faces", "vertices_to", "faces_to", "kept", "mark", "seen", "moved_now",
               "failed_now")
        return self._replace(**{name: np.zeros_like(getattr(self, name)) for name in own}, state=self.state.copy())


@compiled
def changed(rings, f, last, moved):
    """Whether anything round face f moved since the time `last` (0: never) at which single steps failed at it: if not,
    they would fail again. moved (n,): when each vertex did."""
    if last == 0:
        return True
    for c in range(3):
        v = rings.F[f, c]
        if moved[v] >= last:
            return True
        for level in range(len(rings.at)):
            for k in range(rings.at[level, v], rings.at[level, v + 1]):
                if moved[rings.around[k]] >= last:
                    return True
    return False


@compiled
def add(v, patch, count):
    """Make v one of the patch's vertices; returns the new count."""
    patch.mark[v] = patch.state[0]
    patch.vertices[count] = v
    return count + 1


@compiled
def add_neighbours(rings, level, v, patch, count):
    """Add the free neighbours of v at a level; returns the new count, that of the room if it does not suffice."""
    for k in range(rings.at[level, v], rings.at[level, v + 1]):
        x = rings.around[k]
        if patch.mark[x] != patch.state[0] and not rings.fixed[x]:
            if count == len(patch.vertices):
                return count
            count = add(x, patch, count)
    return count


@compiled
def gather(rings, level, patch, count):
    """Complete a patch, which so far has `count` vertices of a level (-1: of the base): add the finer vertices that follow
    them and the faces round all, of each level.

    Returns how many vertices there are, or 0 if the room does not suffice.
    """
    levels, found = len(rings.at), 0
    for k in range(levels):
        if k > level:
            for i in range(count):
                if patch.vertices[i] < rings.n[k]:
                    count = add_neighbours(rings, k, patch.vertices[i], patch, count)
        patch.vertices_to[k] = count
        if count == len(patch.vertices):
            return 0
    for k in range(levels):
        for i in range(patch.vertices_to[k]):
            v = patch.vertices[i]
            for j in range(rings.at[k, v], rings.at[k, v + 1]):
                f = rings.faces[j]
                if patch.seen[f] != patch.state[0]:
                    if found == len(patch.faces):
                        return 0
                    patch.seen[f] = patch.state[0]
                    patch.faces[found] = f
                    found += 1
        patch.faces_to[k] = found
    return count


@compiled
def turned(rings, points, patch, first, end, most):
    """How many of the patch's faces number first..end - 1 are turned; more than `most` are not counted."""
    out = 0
    for i in range(first, end):
        if is_flipped(rings.F, points.P, points.N, patch.faces[i]):
            out += 1
            if out > most:
                break
    return out


@compiled
def fitness(rings, points, patch):
    """Of the patch's faces: how many are turned; and of the finest ones the summed bulge, and the summed area projected on
    the surface, from which turned faces take away (times 6)."""
    levels, height, area = len(rings.at), 0.0, 0.0
    finest = patch.faces_to[levels - 2] if levels > 1 else 0
    out = turned(rings, points, patch, 0, finest, finest)
    for i in range(finest, patch.faces_to[levels - 1]):
        f = patch.faces[i]
        product, size, bulge = orientation_measures(points.P, points.N, rings.F[f, 0], rings.F[f, 1], rings.F[f, 2])
        height += bulge
        area += product
        out += not not_flipped(product, size)
    return out, height, area


@compiled
def better(rings, points, patch, before, most, farther, covered):
    """Whether at most `most` of the patch's faces are turned; there may be `farther` times the bulge of `before`, and must
    be `covered` times the area."""
    if turned(rings, points, patch, 0, patch.faces_to[len(rings.at) - 1], most) > most:
        return False
    after = fitness(rings, points, patch)
    return after[1] <= farther * before[1] + 1e-15 and after[2] >= covered * before[2]


@compiled
def save(points, patch, count):
    """Keep where the patch's vertices are."""
    for i in range(count):
        v, kept = patch.vertices[i], patch.kept[i]
        kept[9] = points.face[v]
        for c in range(3):
            kept[c], kept[3 + c], kept[6 + c] = points.b[v, c], points.P[v, c], points.N[v, c]


@compiled
def restore(points, patch, count):
    """Put the patch's vertices back where they were kept."""
    for i in range(count):
        v, kept = patch.vertices[i], patch.kept[i]
        points.face[v] = int(kept[9])
        for c in range(3):
            points.b[v, c], points.P[v, c], points.N[v, c] = kept[c], kept[3 + c], kept[6 + c]


@compiled
def commit(patch, count):
    """Note that the patch's vertices moved for good."""
    patch.state[3] += 1
    for i in range(count):
        patch.moved[patch.vertices[i]] = patch.state[3]

