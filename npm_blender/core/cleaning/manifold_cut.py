"""Cuts where a surface is no manifold: edges of more than two faces, of two that disagree, vertices of several fans.

No face goes and no vertex moves: faces come apart, and get copies of the vertices that they shared (Gueziec et al. 2001, with
our pairing of the faces at an edge).
"""
import numpy as np

from ..geometry import end_of, find_root, next_halfedge
from ..jit import compiled
from .edge_groups import EdgeGroups, join_corners


def cut(V: np.ndarray, groups: EdgeGroups) -> tuple[np.ndarray, np.ndarray, int, int]:
    """An oriented edge- and vertex-manifold with the same faces: V with copies at its end, F, edges opened, vertices copied.

    Faces stay joined across edges of two faces that agree in direction. Where more meet, those that enclose solid are
    paired (each wedge of solid keeps its two faces) and the rest come apart. Every fan of corners gets its own vertex.
    """
    flat = np.ascontiguousarray(groups.F, np.int32).reshape(-1)
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
    opened = int(((groups.sizes > 2) | groups.disagree()).sum())
    if len(source):
        V = np.concatenate([V, V[source]])
    return V, new.reshape(-1, 3), opened, len(source)


@compiled(allocates=True)
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
            r = V[end_of(flat, next_halfedge(group[i]))] - V[low]
            r = r - axis * (r * axis).sum()
            if i == 0:
                across = r / max(np.sqrt((r * r).sum()), 1e-300)
                up[0] = axis[1] * across[2] - axis[2] * across[1]
                up[1] = axis[2] * across[0] - axis[0] * across[2]
                up[2] = axis[0] * across[1] - axis[1] * across[0]
            angle[i] = np.arctan2((r * up).sum(), (r * across).sum())
        # going round the edge, solid lies between a face that runs down the edge and the next one that runs up
        by_angle = group[np.argsort(angle, kind="mergesort")]
        for i in range(k):
            h, j = by_angle[i], by_angle[(i + 1) % k]
            if flat[h] == high and flat[j] == low:
                pair[h], pair[j] = j, h
    return pair


@compiled(allocates=True)
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
        root = find_root(parent, h)
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


@compiled(allocates=True)
def _bad_halfedges(flat, halfedges, starts):
    """(3 m,) bool: half-edges of edges with more than two faces, or two that run the same way."""
    bad = np.zeros(len(flat), np.bool_)
    for g in range(len(starts) - 1):
        k = starts[g + 1] - starts[g]
        if k > 2 or (k == 2 and flat[halfedges[starts[g]]] == flat[halfedges[starts[g] + 1]]):
            bad[halfedges[starts[g]:starts[g + 1]]] = True
    return bad
