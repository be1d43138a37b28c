"""Faces flipped so that neighbours agree, closed parts outward; where a surface is one-sided, a short cut is chosen."""
import numpy as np

from ..geometry import BVH_STACK, build_bvh
from ..jit import compiled
from .edge_groups import EdgeGroups


@compiled(allocates=True)
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


def orient(V: np.ndarray, groups: EdgeGroups) -> tuple[np.ndarray, int, int]:
    """Faces flipped so that neighbours agree; faces flipped one by one, and faces of closed parts flipped outward.

    Parts are joined across edges of exactly two faces. An inconsistent part takes the outward side where it is closed
    and its majority's side where it is open. A consistent closed part that is inside out is flipped too, unless it is
    a cavity, that is, its box lies in that of another closed part. A one-sided part keeps edges where its faces
    disagree, along a line that no flip of a single face shortens; `cut` opens those.
    """
    F, flat = groups.F, groups.F.reshape(-1)
    part, flipped, conflict = _parities(flat, groups.halfedges, groups.starts, len(F))
    if conflict.any():
        _straighten(flat, groups.halfedges, groups.starts, flipped, conflict)
    ids, part = np.unique(part, return_inverse=True)
    part = part.reshape(-1)
    volume = _volumes(V, F, *((V.min(0) + V.max(0)) / 2))
    open_edge = (groups.sizes != 2) | conflict
    of_halfedge = np.repeat(open_edge, groups.sizes)
    opened = np.zeros(len(ids), bool)
    opened[part[groups.halfedges[of_halfedge] // 3]] = True
    faces, minority = np.bincount(part), np.bincount(part, flipped)
    signed = np.bincount(part, np.where(flipped, -volume, volume))
    mixed = minority > 0
    swap = mixed & np.where(opened, minority > faces / 2, signed < 0)
    flipped ^= swap[part]
    singly = int(flipped.sum())
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
        boxes = np.concatenate([low, high], 1)
        inside_out = closed[signed[closed] < 0]
        outward[inside_out] ^= ~_inside(boxes[inside_out], boxes[closed[signed[closed] > 0]])
        flipped = flipped ^ outward[part]
    if flipped.any():
        F = np.where(flipped[:, None], F[:, ::-1], F)
    return F, singly, int(outward[part].sum())


def _inside(boxes: np.ndarray, of: np.ndarray) -> np.ndarray:
    """(k,) bool: boxes (k, 6), low and high corner, that lie in one of the boxes `of` (j, 6)."""
    if len(of) == 0:
        return np.zeros(len(boxes), bool)
    nodes, links, order = build_bvh(np.concatenate([of, of[:, 3:]], 1))
    return _stab(boxes, of[order], nodes, links)


@compiled
def _holds(outer, inner):
    return (outer[0] <= inner[0] and outer[1] <= inner[1] and outer[2] <= inner[2]
            and outer[3] >= inner[3] and outer[4] >= inner[4] and outer[5] >= inner[5])


@compiled(allocates=True)
def _stab(boxes, of, nodes, links):
    out, stack = np.zeros(len(boxes), np.bool_), np.zeros(BVH_STACK, np.int32)
    for i in range(len(boxes)):
        top, stack[0] = 1, 0
        while top and not out[i]:
            top -= 1
            node = stack[top]
            if not _holds(nodes[node], boxes[i]):
                continue
            first, count = links[node, 0], links[node, 1]
            if count == 0:
                stack[top], stack[top + 1] = first, first + 1
                top += 2
            for j in range(first, first + count):
                out[i] = out[i] or _holds(of[j], boxes[i])
    return out


@compiled(allocates=True)
def _straighten(flat, halfedges, starts, flipped, conflict):
    """Flip faces most of whose edges are in conflict until there are none; changes flipped (m,) and conflict (e,).

    Every flip leaves fewer edges in conflict, so it ends.
    """
    edge = np.zeros(len(flat), np.int64)
    for g in range(len(starts) - 1):
        for i in range(starts[g], starts[g + 1]):
            edge[halfedges[i]] = g
    todo = [np.int64(0) for _ in range(0)]
    for g in range(len(starts) - 1):
        if conflict[g]:
            todo.append(halfedges[starts[g]] // 3)
            todo.append(halfedges[starts[g] + 1] // 3)
    while len(todo):
        f = todo.pop()
        bad, fine = 0, 0
        for h in range(3 * f, 3 * f + 3):
            g = edge[h]
            if starts[g + 1] - starts[g] == 2:
                bad += conflict[g]
                fine += not conflict[g]
        if bad <= fine:
            continue
        flipped[f] = not flipped[f]
        for h in range(3 * f, 3 * f + 3):
            g = edge[h]
            if starts[g + 1] - starts[g] == 2:
                conflict[g] = not conflict[g]
                todo.append(halfedges[starts[g]] // 3)
                todo.append(halfedges[starts[g] + 1] // 3)


@compiled(allocates=True)
def _parities(flat, halfedges, starts, m):
    """Part of each face, whether it is flipped against its part's first face, and edges where that is contradictory."""
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
    flipped = np.zeros(m, np.bool_)
    for f in range(m):
        root, p = _root(parent, parity, f)
        flipped[f] = p == 1
        parent[f], parity[f] = root, p
    return parent, flipped, conflict


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
