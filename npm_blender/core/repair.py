"""The single repairs that `clean` applies, each a function from arrays to arrays and the number of things it changed.

All keep the vertices they are given and change only faces, except `cut`, which appends copies of vertices; unused
vertices are dropped once, at the end, by `compact`.
"""
import numpy as np

from .adjacency import EdgeGroups, end_of, find, join_corners, next_of, vertex_parts
from .jit import compiled
from .weld import weld

NEAR = 1e-6  # of the box: how far apart border vertices may be and still be one
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


@compiled
def _volumes(V, F, x, y, z):
    """Six times the signed volume that each face spans with the point (x, y, z), (m,) float64."""
    out = np.zeros(len(F))
    for f in range(len(F)):
        i, j, k = F[f, 0], F[f, 1], F[f, 2]
        ax, ay, az = V[i, 0] - x, V[i, 1] - y, V[i, 2] - z
        bx, by, bz = V[j, 0] - x, V[j, 1] - y, V[j, 2] - z
        cx, cy, cz = V[k, 0] - x, V[k, 1] - y, V[k, 2] - z
        out[f] = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return out


def repeated_corners(F: np.ndarray) -> np.ndarray:
    """(m,) bool: faces that name a vertex twice."""
    return (F[:, 0] == F[:, 1]) | (F[:, 1] == F[:, 2]) | (F[:, 2] == F[:, 0])


def duplicates(F: np.ndarray) -> np.ndarray:
    """(m,) bool: faces with the same three vertices as an earlier one, in any order."""
    a, b, c = F.T
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    first, _ = weld(np.stack([low, a.astype(np.int64) + b + c - low - high, high], 1).astype(np.float64))
    again = np.ones(len(F), bool)
    again[first] = False
    return again


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


def weld_borders(V: np.ndarray, F: np.ndarray, groups: EdgeGroups) -> tuple[np.ndarray, int]:
    """Faces with coincident border vertices made one, and the number of vertices that went.

    Only where fewer border edges are left once the result is cut into a manifold again. Vertices inside a surface are
    never joined, so surfaces that merely touch stay apart. Exact coincidence is tried first, then NEAR times the box.
    """
    changed = 0
    for near in (0.0, NEAR * float(np.ptp(V, axis=0).max())):
        alone = groups.halfedges[groups.starts[:-1][groups.sizes == 1]]
        if len(alone) == 0:
            break
        border = np.unique([F.reshape(-1)[alone], np.roll(F, -1, 1).reshape(-1)[alone]])
        joined = np.arange(len(V), dtype=np.int32)
        joined[border] = border[_places(V[border], near)]
        count = int((joined != np.arange(len(V))).sum())
        if count:
            trial = joined[F]
            trial = trial[~repeated_corners(trial)]
            trial_groups = EdgeGroups.of(trial, len(V))
            if _borders_after_cut(V, trial, trial_groups) < len(alone):
                F, groups, changed = trial, trial_groups, changed + count
    return F, changed


def _borders_after_cut(V: np.ndarray, F: np.ndarray, groups: EdgeGroups) -> int:
    """Border edges of the manifold that F (m, 3) would be made."""
    sizes = groups.sizes
    if (sizes > 2).any() or _disagree(F.reshape(-1), groups).any():
        F = F[~duplicates(F)]
        F, _, _ = orient(V, F, EdgeGroups.of(F, len(V)))
        V, F, _, _ = cut(V, F, EdgeGroups.of(F, len(V)))
        sizes = EdgeGroups.of(F, len(V)).sizes
    return int((sizes == 1).sum())


def _places(V: np.ndarray, near: float) -> np.ndarray:
    """Row of the first point at about the place of each point of V (n, 3), (n,): exactly, or within near < distance."""
    if near == 0:
        first, place = weld(V)
        return first[place]
    a, b = [], []
    for shift in np.ndindex(2, 2, 2):  # two points closer than `near` share a cell of one of these grids
        first, place = weld(np.floor(V / (2 * near) + 0.5 * np.array(shift)))
        a.append(np.arange(len(V)))
        b.append(first[place])
    return vertex_parts(len(V), np.concatenate(a), np.concatenate(b))


def orient(V: np.ndarray, F: np.ndarray, groups: EdgeGroups) -> tuple[np.ndarray, int, int]:
    """Faces turned so that neighbours agree; faces turned one by one, and faces of closed parts turned outward.

    Parts are joined across edges of exactly two faces. An inconsistent part takes the outward side where it is closed
    and its majority's side where it is open. A consistent closed part that is inside out is turned too, unless it is
    a cavity, that is, its box lies in that of another closed part. A one-sided part keeps edges where its faces
    disagree; `cut` opens those.
    """
    part, turned, conflict = _parities(F.reshape(-1), groups.halfedges, groups.starts, len(F))
    ids, part = np.unique(part, return_inverse=True)
    part = part.reshape(-1)
    volume = _volumes(V, F, *((V.min(0) + V.max(0)) / 2))
    open_edge = (groups.sizes != 2) | conflict
    of_halfedge = np.repeat(open_edge, groups.sizes)
    opened = np.zeros(len(ids), bool)
    opened[part[groups.halfedges[of_halfedge] // 3]] = True
    faces, minority = np.bincount(part), np.bincount(part, turned)
    signed = np.bincount(part, np.where(turned, -volume, volume))
    mixed = minority > 0
    swap = mixed & np.where(opened, minority > faces / 2, signed < 0)
    turned ^= swap[part]
    singly = int(turned.sum())
    closed = np.flatnonzero(~opened)
    signed = np.where(swap, -signed, signed)
    outward = np.zeros(len(ids), bool)
    if len(closed) and (signed[closed] < 0).any():
        outward[closed] = signed[closed].sum() < 0
        signed = np.where(outward, -signed, signed)
        low, high = np.full((len(ids), 3), np.inf), np.full((len(ids), 3), -np.inf)
        corners = V[F]
        np.minimum.at(low, part, corners.min(1))
        np.maximum.at(high, part, corners.max(1))
        solid = closed[signed[closed] > 0]
        for i in closed[signed[closed] < 0]:
            if not ((low[solid] <= low[i]) & (high[solid] >= high[i])).all(1).any():
                outward[i] ^= True
        turned = turned ^ outward[part]
    if turned.any():
        F = np.where(turned[:, None], F[:, ::-1], F)
    return F, singly, int(outward[part].sum())


@compiled
def _parities(flat, halfedges, starts, m):
    """Part of each face, whether it is turned against its part's first face, and edges where that is contradictory."""
    parent, parity = np.arange(m).astype(np.int32), np.zeros(m, np.uint8)  # parity: against the parent
    conflict = np.zeros(len(starts) - 1, np.bool_)
    for g in range(len(starts) - 1):
        if starts[g + 1] - starts[g] != 2:
            continue
        h, k = halfedges[starts[g]], halfedges[starts[g] + 1]
        i, p = _root(parent, parity, h // 3)
        j, q = _root(parent, parity, k // 3)
        differ = np.uint8(flat[h] == flat[k])
        if i == j:
            conflict[g] = p ^ q != differ
        else:
            low, high = min(i, j), max(i, j)
            parent[high], parity[high] = low, p ^ q ^ differ
    turned = np.zeros(m, np.bool_)
    for f in range(m):
        root, p = _root(parent, parity, f)
        turned[f] = p == 1
        parent[f], parity[f] = root, p
    return parent, turned, conflict


@compiled
def _root(parent, parity, i):
    p, top = np.uint8(0), i
    while parent[top] != top:
        p ^= parity[top]
        top = parent[top]
    total = p
    while parent[i] != top and i != top:  # hang the whole path under the root
        above, rest = parent[i], p ^ parity[i]
        parent[i], parity[i] = top, p
        i, p = above, rest
    return top, total


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
