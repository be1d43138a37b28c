"""The single repairs that `clean` applies, each a function from arrays to arrays and the number of things it changed.

All keep the vertices they are given and change only faces, except `cut`, which appends copies of vertices; unused
vertices are dropped once, at the end, by `compact`.
"""
import numpy as np

from .adjacency import EdgeGroups, end_of, find, join_corners, next_of, vertex_parts
from .coverings import duplicates
from .jit import compiled
from .orientation import orient
from .progress import Progress, no_progress
from .stitch import split_at_junctions
from .weld import near_places, weld

NEAR = 1e-6  # of the box: how far apart border vertices may be and still be one
SINGLE = 2.0**-22  # two units in the last place of single precision
FLAT = 1e-10  # twice the area over the squared longest edge, below which a face counts as having no area


@compiled
def flatness(V, F):
    """Twice the area over the squared longest edge of each face, (m,) float64; 0 for faces without extent."""
    out = np.zeros(len(F))
    for f in range(len(F)):
        i, j, k = F[f, 0], F[f, 1], F[f, 2]
        ax, ay, az = V[j, 0] - V[i, 0], V[j, 1] - V[i, 1], V[j, 2] - V[i, 2]
        bx, by, bz = V[k, 0] - V[i, 0], V[k, 1] - V[i, 1], V[k, 2] - V[i, 2]
        x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        longest = max(ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz,
                      (ax - bx) ** 2 + (ay - by) ** 2 + (az - bz) ** 2)
        if longest > 0:
            out[f] = np.sqrt(x * x + y * y + z * z) / longest
    return out


def repeated_corners(F: np.ndarray) -> np.ndarray:
    """(m,) bool: faces that name a vertex twice."""
    return (F[:, 0] == F[:, 1]) | (F[:, 1] == F[:, 2]) | (F[:, 2] == F[:, 0])


def collapse_zero_edges(V: np.ndarray, F: np.ndarray, groups: EdgeGroups) -> tuple[np.ndarray, int]:
    """Faces with the ends of every edge of zero length made one vertex, and the number of vertices that went."""
    start = F.reshape(-1)[groups.halfedges[groups.starts[:-1]]]
    end = np.roll(F, -1, 1).reshape(-1)[groups.halfedges[groups.starts[:-1]]]
    zero = (V[start, 0] == V[end, 0]) & (start != end)
    zero[zero] = (V[start[zero]] == V[end[zero]]).all(1)
    if not zero.any():
        return F, 0
    part = vertex_parts(len(V), start[zero], end[zero])
    return part[F], int((part != np.arange(len(V))).sum())


def weld_borders(V: np.ndarray, F: np.ndarray, groups: EdgeGroups,
                 progress: Progress = no_progress) -> tuple[np.ndarray, EdgeGroups, int]:
    """Faces with coincident border vertices made one, their edges, and the number of vertices that went.

    Only where fewer border edges are left once the result is cut into a manifold again. Vertices inside a surface are
    never joined, so surfaces that merely touch stay apart. Exact coincidence is tried first, then a distance of NEAR
    times the box, of a tenth of the shortest border edge at either vertex if that is less: no edge is collapsed.
    """
    changed = 0
    for near in (0.0, reach_of(V, F)):
        alone = groups.halfedges[groups.starts[:-1][groups.sizes == 1]]
        if len(alone) == 0:
            break
        a, b = F.reshape(-1)[alone], np.roll(F, -1, 1).reshape(-1)[alone]
        border = np.unique([a, b])
        progress(near > 0, "Merging vertices")
        first, place = weld(V[border])
        if near:
            length = np.linalg.norm(V[b] - V[a], axis=1)
            shortest = np.full(len(V), near)
            np.minimum.at(shortest, np.concatenate([a, b]), 0.1 * np.concatenate([length, length]))
            least = np.full(len(first), near)
            np.minimum.at(least, place, shortest[border])
            first = first[near_places(V[border[first]], least)]
        joined = np.arange(len(V), dtype=np.int32)
        joined[border] = border[first[place]]
        joined = _apart_along_edges(F, joined)
        count = int((joined != np.arange(len(V))).sum())
        if count:
            progress(0.5 + 0.5 * (near > 0), "Merging vertices")
            trial = joined[F]
            trial_groups = EdgeGroups.of(trial, len(V))
            if borders_after_cut(V, trial, trial_groups) < len(alone):
                F, groups, changed = trial, trial_groups, changed + count
    return F, groups, changed


def reach_of(V: np.ndarray, F: np.ndarray) -> float:
    """How far vertices of faces F (m, 3) may be apart and still be one, in units of V.

    NEAR times the longest side of their box, or what two roundings to single precision leave if V holds only numbers
    of that: far from the origin that is more.
    """
    V = compact(V, F)[0]
    near = NEAR * float(np.ptp(V, axis=0).max())
    largest = float(np.abs(V).max())
    with np.errstate(over="ignore"):
        single = largest * SINGLE > near and (V.astype(np.float32) == V).all()
    if not single:
        return near
    return SINGLE * largest


def _apart_along_edges(F: np.ndarray, joined: np.ndarray) -> np.ndarray:
    """joined (n,) without the places that hold two corners of one face."""
    trial = joined[F]
    broken = repeated_corners(trial)
    if not broken.any():
        return joined
    flat = trial[broken]
    same = np.concatenate([flat[flat[:, k] == flat[:, k - 1], k] for k in range(3)])
    split = np.isin(joined, same)
    return np.where(split, np.arange(len(joined)), joined).astype(np.int32)


def stitch(V: np.ndarray, F: np.ndarray, groups: EdgeGroups,
           progress: Progress = no_progress) -> tuple[np.ndarray, EdgeGroups, int]:
    """Faces with border edges split where border vertices lie on them, their edges, and the number of splits.

    Only where fewer border edges are left once the result is cut into a manifold again.
    """
    borders = int((groups.sizes == 1).sum())
    if borders == 0:
        return F, groups, 0
    trial, splits = split_at_junctions(V, F, groups, reach_of(V, F), progress)
    if splits:
        trial_groups = EdgeGroups.of(trial, len(V))
        if borders_after_cut(V, trial, trial_groups) < borders:
            return trial, trial_groups, splits
    return F, groups, 0


def borders_after_cut(V: np.ndarray, F: np.ndarray, groups: EdgeGroups) -> int:
    """Border edges of the manifold that faces F (m, 3) would be made."""
    sizes = groups.sizes
    if (sizes > 2).any() or _disagree(F.reshape(-1), groups).any():
        F = F[~duplicates(F)]
        F, _, _ = orient(V, F, EdgeGroups.of(F, len(V)))
        V, F, _, _ = cut(V, F, EdgeGroups.of(F, len(V)))
        sizes = EdgeGroups.of(F, len(V)).sizes
    return int((sizes == 1).sum())


def cut(V: np.ndarray, F: np.ndarray, groups: EdgeGroups) -> tuple[np.ndarray, np.ndarray, int, int]:
    """An oriented edge- and vertex-manifold with the same faces: V and F, edges opened, vertices copied.

    Faces stay joined across edges of two faces that agree in direction. Where more meet, those that enclose solid are
    paired (each wedge of solid keeps its two faces) and the rest come apart. Every fan of corners gets its own vertex.
    """
    flat = np.ascontiguousarray(F, np.int32).reshape(-1)
    apart = np.zeros(len(groups.starts) - 1, np.bool_)
    while True:
        pairs = _pairs(V, flat, groups.halfedges, groups.starts, apart)
        new, source = _split(flat, groups.halfedges, groups.starts, pairs, len(V))
        after = EdgeGroups.of(new.reshape(-1, 3), len(V) + len(source))
        bad = _bad_halfedges(new, after.halfedges, after.starts)
        if not bad.any():
            break
        # an edge whose fans meet again elsewhere: open it wholly; each round opens at least one more
        group_of = np.zeros(len(flat), np.int64)
        group_of[groups.halfedges] = np.repeat(np.arange(len(apart)), groups.sizes)
        fresh = np.unique(group_of[bad])
        if apart[fresh].all():
            raise AssertionError("cut did not end in a manifold")  # excluded by the parity of fans; a bug if seen
        apart[fresh] = True
    opened = int(((groups.sizes > 2) | _disagree(flat, groups)).sum())
    if len(source):
        V = np.concatenate([V, V[source]])
    return V, new.reshape(-1, 3), opened, len(source)


def _disagree(flat: np.ndarray, groups: EdgeGroups) -> np.ndarray:
    """(e,) bool: edges of two faces that run along it the same way."""
    two = groups.sizes == 2
    h = groups.starts[:-1][two]
    out = np.zeros(len(two), bool)
    out[two] = flat[groups.halfedges[h]] == flat[groups.halfedges[h + 1]]
    return out


@compiled
def _pairs(V, flat, halfedges, starts, apart):
    """The half-edge that each one stays joined to, or itself, (3 m,) int32."""
    pair = np.arange(len(flat)).astype(np.int32)
    for g in range(len(starts) - 1):
        k = starts[g + 1] - starts[g]
        if k < 2 or apart[g]:
            continue
        group = halfedges[starts[g]:starts[g + 1]]
        if k == 2:
            if flat[group[0]] != flat[group[1]]:
                pair[group[0]], pair[group[1]] = group[1], group[0]
            continue
        low = min(flat[group[0]], end_of(flat, group[0]))
        high = max(flat[group[0]], end_of(flat, group[0]))
        axis = V[high] - V[low]
        axis = axis / max(np.sqrt((axis * axis).sum()), 1e-300)
        across, up = np.zeros(3), np.zeros(3)
        angle = np.zeros(k)
        for i in range(k):
            r = V[end_of(flat, next_of(group[i]))] - V[low]
            r = r - axis * (r * axis).sum()
            if i == 0:
                across = r / max(np.sqrt((r * r).sum()), 1e-300)
                up[0] = axis[1] * across[2] - axis[2] * across[1]
                up[1] = axis[2] * across[0] - axis[0] * across[2]
                up[2] = axis[0] * across[1] - axis[1] * across[0]
            angle[i] = np.arctan2((r * up).sum(), (r * across).sum())
        # turning round the edge, solid lies between a face that runs down the edge and the next one that runs up
        by_angle = group[np.argsort(angle, kind="mergesort")]
        for i in range(k):
            h, j = by_angle[i], by_angle[(i + 1) % k]
            if flat[h] == high and flat[j] == low:
                pair[h], pair[j] = j, h
    return pair


@compiled
def _split(flat, halfedges, starts, pair, n):
    """One vertex for each fan: faces (3 m,), and the vertices that were copied, as n, n + 1, ..."""
    parent = np.arange(len(flat)).astype(np.int32)
    for h in range(len(flat)):
        if pair[h] > h:
            join_corners(parent, flat, h, pair[h])
    new = np.full(len(flat), -1, np.int32)
    taken = np.zeros(n, np.bool_)
    source = []
    for h in range(len(flat)):
        root = find(parent, h)
        if new[root] < 0:
            v = flat[h]
            if taken[v]:
                new[root] = n + len(source)
                source.append(v)
            else:
                new[root] = v
                taken[v] = True
        new[h] = new[root]
    copies = np.zeros(len(source), np.int32)
    for i in range(len(source)):
        copies[i] = source[i]
    return new, copies


@compiled
def _bad_halfedges(flat, halfedges, starts):
    """(3 m,) bool: half-edges of edges with more than two faces, or two that run the same way."""
    bad = np.zeros(len(flat), np.bool_)
    for g in range(len(starts) - 1):
        k = starts[g + 1] - starts[g]
        if k > 2 or (k == 2 and flat[halfedges[starts[g]]] == flat[halfedges[starts[g] + 1]]):
            bad[halfedges[starts[g]:starts[g + 1]]] = True
    return bad


def compact(V: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """V and F without unused vertices, order kept."""
    used = np.zeros(len(V), bool)
    used[F] = True
    if used.all():
        return V, F
    return V[used], (np.cumsum(used) - 1).astype(np.int32)[F]
