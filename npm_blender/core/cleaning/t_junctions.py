"""T-junctions: border vertices that lie on a border edge of other faces. The edge is split there, so that both sides
of the crack use the same vertices; nothing moves."""
import numpy as np

from ..geometry import BVH_STACK, build_bvh
from ..jit import compiled
from ..mesh import next_halfedges, prev_halfedges
from ..progress import Progress, no_progress
from .border_welding import borders_after_cut, reach_of
from .edge_groups import EdgeGroups

ROUNDS = 3  # a face has one edge split in each
SLICE = 2000  # vertices between two calls of `progress`
WORK = 64  # box and distance tests for each border edge, at most; more are needed where hundreds lie on each other


def close_t_junctions(V: np.ndarray, groups: EdgeGroups, progress: Progress = no_progress) -> tuple[EdgeGroups, int]:
    """The edges of faces whose border edges were split where border vertices lie on them, and the number of splits.

    Only where fewer border edges are left once the result is cut into a manifold again.
    """
    borders = len(groups.border)
    if borders == 0:
        return groups, 0
    trial, splits = split_at_junctions(V, groups, reach_of(V, groups.F), progress)
    if splits and borders_after_cut(V, trial) < borders:
        return trial, splits
    return groups, 0


def split_at_junctions(V: np.ndarray, groups: EdgeGroups, near: float,
                       progress: Progress = no_progress) -> tuple[EdgeGroups, int]:
    """The edges of faces with border edges split at the border vertices on them, and the number of splits.

    near: how far a vertex may be from an edge, in units of V; a hundredth of the edge and a tenth of the vertex's
    shortest border edge also bound it. An edge is split only where a piece of it then meets a border edge of another
    face. The face is split into a fan from its opposite corner.
    """
    total = 0
    for _ in range(ROUNDS):
        F, splits = _split_once(V, groups, near, progress)
        groups, total = groups.replaced(F), total + splits
        if splits == 0:
            break
    return groups, total


def _split_once(V: np.ndarray, groups: EdgeGroups, near: float, progress: Progress) -> tuple[np.ndarray, int]:
    """One border edge of each face split: faces (m', 3), or the very array that they were, and the number of splits."""
    F, alone, flat = groups.F, groups.border, groups.F.reshape(-1)
    a, b = flat[alone], flat[next_halfedges(alone)]
    length = np.linalg.norm(V[b] - V[a], axis=1)
    if len(alone) < 3 or not length.max() > 0:
        return F, 0
    shortest = np.full(len(V), np.inf)
    np.minimum.at(shortest, np.concatenate([a, b]), np.concatenate([length, length]))
    points = np.flatnonzero(np.isfinite(shortest)).astype(np.int32)
    # each segment is a triangle without area for the search
    nodes, links, order = build_bvh(np.concatenate([V[a], V[b], V[b]], 1))
    low, high, tolerance = a[order], b[order], np.minimum(near, 0.01 * length[order])
    found, work = [], np.array([WORK * (len(a) + len(points)) + 1_000_000])
    for i in range(0, len(points), SLICE):
        progress(i / len(points), "Closing T-junctions")
        some = points[i:i + SLICE]
        found.append(_on_edges(V, some, np.minimum(near, 0.1 * shortest[some]), low, high, tolerance, nodes, links, work))
    edge, point, along = (np.concatenate(column) for column in zip(*found, strict=True))
    edge = order[edge]
    third = flat[prev_halfedges(alone)]
    degenerate = third[edge] == point  # a face without area; `remove_flat_faces` sees to it
    edge, point, along = edge[~degenerate], point[~degenerate], along[~degenerate]
    if len(edge) == 0:
        return F, 0
    rank = np.lexsort((point, along, edge))
    edge, point = edge[rank], point[rank]
    # the pieces of every border edge, split or not; those that two edges have are what was looked for
    start, end = np.concatenate([a, point]), np.concatenate([b, point])
    owner = np.concatenate([np.arange(len(a)), edge])
    at = np.lexsort((np.concatenate([np.zeros(len(a)), np.ones(len(edge))]), owner))
    owner, start, end = owner[at], start[at], end[at]
    last = np.append(owner[1:] != owner[:-1], True)
    end = np.where(last, b[owner], np.append(start[1:], 0))
    pair = np.stack([np.minimum(start, end), np.maximum(start, end)], 1)
    _, which, count = np.unique(pair, axis=0, return_inverse=True, return_counts=True)
    meets = np.bincount(owner, count[which.reshape(-1)] > 1, len(a)) > 0
    # one edge of each face, the first
    chosen = np.flatnonzero(meets & (np.bincount(edge, minlength=len(a)) > 0))
    chosen = chosen[np.unique(alone[chosen] // 3, return_index=True)[1]]
    picked = np.zeros(len(a), bool)
    picked[chosen] = True
    if not len(chosen):
        return F, 0
    ours = picked[owner]
    fans = np.stack([start[ours], end[ours], third[owner[ours]]], 1)
    keep = np.ones(len(F), bool)
    keep[alone[chosen] // 3] = False
    return np.concatenate([F[keep], fans]).astype(np.int32), len(fans) - len(chosen)


@compiled(allocates=True)
def _on_edges(V, points, reach, a, b, tolerance, nodes, links, budget):
    """Edges a-b (in leaf order), points and places along the edge, for every point in the interior of an edge.

    budget (1,): the tests that are left; the points after they are used up are not looked at.
    """
    edges, found, along = [], [], []
    stack = np.zeros(BVH_STACK, np.int32)
    work = budget[0]
    for i in range(len(points)):
        if work < 0:
            break
        p, r = points[i], reach[i]
        x, y, z = V[p, 0], V[p, 1], V[p, 2]
        top, stack[0] = 1, 0
        while top:
            top -= 1
            work -= 1
            node = stack[top]
            box = nodes[node]
            if (x < box[0] - r or y < box[1] - r or z < box[2] - r
                    or x > box[3] + r or y > box[4] + r or z > box[5] + r):
                continue
            first, count = links[node, 0], links[node, 1]
            if count == 0:
                stack[top], stack[top + 1] = first, first + 1
                top += 2
            for e in range(first, first + count):
                work -= 1
                s, t = a[e], b[e]
                if s == p or t == p:
                    continue
                ux, uy, uz = V[t, 0] - V[s, 0], V[t, 1] - V[s, 1], V[t, 2] - V[s, 2]
                px, py, pz = x - V[s, 0], y - V[s, 1], z - V[s, 2]
                length = np.sqrt(ux * ux + uy * uy + uz * uz)
                if not length > 0:
                    continue
                w = (px * ux + py * uy + pz * uz) / length
                near = min(r, tolerance[e])
                d2 = px * px + py * py + pz * pz - w * w
                if w > near and w < length - near and w > 1e-6 * length and w < (1 - 1e-6) * length and d2 <= near * near:
                    edges.append(e)
                    found.append(p)
                    along.append(w)
    budget[0] = work
    out = np.zeros(len(edges), np.int64), np.zeros(len(edges), np.int32), np.zeros(len(edges))
    for i in range(len(edges)):
        out[0][i], out[1][i], out[2][i] = edges[i], found[i], along[i]
    return out
