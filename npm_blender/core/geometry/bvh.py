"""A bounding volume hierarchy over triangles: a binary tree of axis-aligned boxes, each round all triangles below it, in float64.

A query for the closest point skips every box that is farther away than the best triangle so far, and looks into the nearer of
two boxes first: it looks at few triangles, and the answer is exact. The tree is built top down: the centroids are put into
BINS slabs along their longest axis, and the cut between two slabs is taken that costs least by the surface-area heuristic
(MacDonald and Booth 1990; binned by Wald 2007), count(left) area(left) + count(right) area(right). Nodes lie in two arrays:
`boxes` (k, 6) float64, low corner then high corner, and `links` (k, 2) int32: for an inner node (left child, 0), its right
child is left + 1; for a leaf (first triangle, count) with count > 0. Triangles are stored in leaf order as `corners` (m, 9)
float64, three corners a row; `order` (m,) int32 is the face of each row.
"""
import numpy as np

from ..jit import compiled

LEAF = 4  # triangles in a leaf, at most (more only where all centroids coincide)
BINS = 16
BVH_STACK = 128  # depth of the traversal; the build switches to median splits below DEPTH, so it cannot overflow
DEPTH = 60


@compiled(allocates=True)
def build_bvh(corners):
    """boxes (k, 6) float64, links (k, 2) int32, order (m,) int32 of the triangles `corners` (m, 9) float64, m > 0.

    What they hold: see the module. Whoever traverses them needs a stack of BVH_STACK nodes.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import build_bvh
    >>> corners = np.arange(8.0)[:, None] + np.array([0.0, 0, 0, 1, 0, 0, 0, 1, 0])  # eight triangles along the diagonal
    >>> boxes, links, order = build_bvh(corners)
    >>> boxes[0].tolist(), links.tolist()  # two leaves of four triangles
    ([0.0, 0.0, 0.0, 8.0, 8.0, 7.0], [[1, 0], [0, 4], [4, 4]])
    """
    m = len(corners)
    low, high, centre = np.zeros((m, 3)), np.zeros((m, 3)), np.zeros((m, 3))
    for i in range(m):
        for x in range(3):
            p, q, r = corners[i, x], corners[i, 3 + x], corners[i, 6 + x]
            low[i, x], high[i, x] = min(p, q, r), max(p, q, r)
            centre[i, x] = (low[i, x] + high[i, x]) / 2
    order = np.arange(m).astype(np.int32)
    boxes, links = np.zeros((2 * m, 6)), np.zeros((2 * m, 2), np.int32)
    todo = np.zeros((BVH_STACK, 4), np.int64)  # node, first, stop, depth
    todo[0, 2] = m
    waiting, nodes = 1, 1
    while waiting:
        waiting -= 1
        node, first, stop, depth = todo[waiting]
        _bound(boxes[node], low, high, order, first, stop)
        if stop - first <= LEAF:
            links[node, 0], links[node, 1] = first, stop - first
            continue
        middle = _split(low, high, centre, order, first, stop, depth >= DEPTH)
        links[node, 0], links[node, 1] = nodes, 0
        todo[waiting] = (nodes, first, middle, depth + 1)
        todo[waiting + 1] = (nodes + 1, middle, stop, depth + 1)
        waiting += 2
        nodes += 2
    return boxes[:nodes].copy(), links[:nodes].copy(), order


@compiled
def _bound(box, low, high, order, first, stop):
    box[:3], box[3:] = np.inf, -np.inf
    for k in range(first, stop):
        i = order[k]
        for x in range(3):
            box[x] = min(box[x], low[i, x])
            box[3 + x] = max(box[3 + x], high[i, x])


@compiled
def refit_bvh(corners, boxes, links):
    """Boxes in place for triangles that moved: corners (m, 9), in the order of the tree; children come after their parents.

    >>> import numpy as np
    >>> from npm_blender.core.geometry import build_bvh, refit_bvh
    >>> corners = np.arange(8.0)[:, None] + np.array([0.0, 0, 0, 1, 0, 0, 0, 1, 0])
    >>> boxes, links, order = build_bvh(corners)
    >>> refit_bvh(corners[order] + 1, boxes, links)
    >>> boxes[0].tolist()
    [1.0, 1.0, 1.0, 9.0, 9.0, 8.0]
    """
    for node in range(len(boxes) - 1, -1, -1):
        box = boxes[node]
        if links[node, 1] == 0:
            left, right = boxes[links[node, 0]], boxes[links[node, 0] + 1]
            for x in range(3):
                box[x], box[3 + x] = min(left[x], right[x]), max(left[3 + x], right[3 + x])
            continue
        box[:3], box[3:] = np.inf, -np.inf
        for i in range(links[node, 0], links[node, 0] + links[node, 1]):
            for k in range(9):
                x = k % 3
                box[x], box[3 + x] = min(box[x], corners[i, k]), max(box[3 + x], corners[i, k])


@compiled
def _half_area(box):
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    return x * y + y * z + z * x


@compiled(allocates=True)
def _split(low, high, centre, order, first, stop, balanced):
    """Reorder order[first:stop] into two parts and return where the second starts, strictly inside."""
    a, b = np.full(3, np.inf), np.full(3, -np.inf)
    for k in range(first, stop):
        for x in range(3):
            a[x] = min(a[x], centre[order[k], x])
            b[x] = max(b[x], centre[order[k], x])
    axis = np.argmax(b - a)
    start, extent = a[axis], b[axis] - a[axis]
    if not extent > 0 or balanced:
        return (first + stop) // 2  # centroids coincide, or the tree got too deep: halve as they lie
    scale = BINS / extent
    count = np.zeros(BINS, np.int64)
    box = np.zeros((BINS, 6))
    box[:, :3], box[:, 3:] = np.inf, -np.inf
    for k in range(first, stop):
        i = order[k]
        c = min(BINS - 1, int((centre[i, axis] - start) * scale))
        count[c] += 1
        for x in range(3):
            box[c, x] = min(box[c, x], low[i, x])
            box[c, 3 + x] = max(box[c, 3 + x], high[i, x])
    right_cost = np.zeros(BINS)
    grown, total = box[BINS - 1].copy(), count[BINS - 1]
    for c in range(BINS - 1, 0, -1):
        total += count[c] if c < BINS - 1 else 0
        for x in range(3):
            grown[x] = min(grown[x], box[c, x])
            grown[3 + x] = max(grown[3 + x], box[c, 3 + x])
        right_cost[c] = total * _half_area(grown) if total else 0.0
    best, best_cost, total = 1, np.inf, 0
    grown = box[0].copy()
    for c in range(1, BINS):
        total += count[c - 1]
        for x in range(3):
            grown[x] = min(grown[x], box[c - 1, x])
            grown[3 + x] = max(grown[3 + x], box[c - 1, 3 + x])
        cost = total * _half_area(grown) + right_cost[c]
        if 0 < total < stop - first and cost < best_cost:
            best, best_cost = c, cost
    i, j = first, stop - 1
    while i <= j:
        if min(BINS - 1, int((centre[order[i], axis] - start) * scale)) < best:
            i += 1
        else:
            order[i], order[j] = order[j], order[i]
            j -= 1
    return i if first < i < stop else (first + stop) // 2


@compiled(inline="always")
def _on_segment(px, py, pz, ax, ay, az, bx, by, bz):
    """Squared distance and closest point of the segment a-b to p."""
    ux, uy, uz = bx - ax, by - ay, bz - az
    length = ux * ux + uy * uy + uz * uz
    t = ((px - ax) * ux + (py - ay) * uy + (pz - az) * uz) / length if length > 0 else 0.0
    t = min(1.0, max(0.0, t))
    x, y, z = ax + t * ux, ay + t * uy, az + t * uz
    return (x - px) ** 2 + (y - py) ** 2 + (z - pz) ** 2, x, y, z


@compiled
def _on_triangle(px, py, pz, t):
    """Squared distance and closest point of the triangle t (9,) to p.

    p projects inside where it is on the inner side of the three edges; otherwise the closest point lies on an edge
    that p is outside of. Triangles without a normal are their three edges.
    """
    ax, ay, az, bx, by, bz, cx, cy, cz = t[0], t[1], t[2], t[3], t[4], t[5], t[6], t[7], t[8]
    ux, uy, uz = bx - ax, by - ay, bz - az
    vx, vy, vz = cx - bx, cy - by, cz - bz
    wx, wy, wz = ax - cx, ay - cy, az - cz
    nx, ny, nz = uz * wy - uy * wz, ux * wz - uz * wx, uy * wx - ux * wy
    nn = nx * nx + ny * ny + nz * nz
    qx, qy, qz = px - ax, py - ay, pz - az
    rx, ry, rz = px - bx, py - by, pz - bz
    sx, sy, sz = px - cx, py - cy, pz - cz
    flat = nn <= 1e-28 * (ux * ux + uy * uy + uz * uz) * (wx * wx + wy * wy + wz * wz)
    out_u = flat or (uy * qz - uz * qy) * nx + (uz * qx - ux * qz) * ny + (ux * qy - uy * qx) * nz < 0
    out_v = flat or (vy * rz - vz * ry) * nx + (vz * rx - vx * rz) * ny + (vx * ry - vy * rx) * nz < 0
    out_w = flat or (wy * sz - wz * sy) * nx + (wz * sx - wx * sz) * ny + (wx * sy - wy * sx) * nz < 0
    if not (out_u or out_v or out_w):
        h = (qx * nx + qy * ny + qz * nz) / nn
        return h * h * nn, px - h * nx, py - h * ny, pz - h * nz
    best, x, y, z = np.inf, 0.0, 0.0, 0.0
    if out_u:
        best, x, y, z = _on_segment(px, py, pz, ax, ay, az, bx, by, bz)
    if out_v:
        d, i, j, k = _on_segment(px, py, pz, bx, by, bz, cx, cy, cz)
        if d < best:
            best, x, y, z = d, i, j, k
    if out_w:
        d, i, j, k = _on_segment(px, py, pz, cx, cy, cz, ax, ay, az)
        if d < best:
            best, x, y, z = d, i, j, k
    return best, x, y, z


@compiled(inline="always")
def _to_box(px, py, pz, box):
    """Squared distance of p to a box (6,)."""
    x = max(box[0] - px, px - box[3], 0.0)
    y = max(box[1] - py, py - box[4], 0.0)
    z = max(box[2] - pz, pz - box[5], 0.0)
    return x * x + y * y + z * z


@compiled(allocates=True)
def closest_in_bvh(P, turn, corners, boxes, links):
    """Closest points of P (n, 3), answered in the order `turn` (n,): distance (n,), point (n, 3), row of corners (n,).

    Neighbouring turns should be close in space: each search starts from the answer of the one before.
    """
    n = len(P)
    distance, point, row = np.zeros(n), np.zeros((n, 3)), np.zeros(n, np.int32)
    stack, reach = np.zeros(BVH_STACK, np.int32), np.zeros(BVH_STACK)
    found = 0
    for k in range(n):
        q = turn[k]
        px, py, pz = P[q, 0], P[q, 1], P[q, 2]
        best, x, y, z = _on_triangle(px, py, pz, corners[found])
        top = 1
        stack[0], reach[0] = 0, 0.0
        while top:
            top -= 1
            if reach[top] >= best:
                continue
            node = stack[top]
            while links[node, 1] == 0:
                left = links[node, 0]
                near, far = left, left + 1
                d0 = _to_box(px, py, pz, boxes[near])
                d1 = _to_box(px, py, pz, boxes[far])
                if d1 < d0:
                    near, far, d0, d1 = far, near, d1, d0
                if d1 < best:
                    stack[top], reach[top] = far, d1
                    top += 1
                if d0 >= best:
                    node = -1
                    break
                node = near
            if node < 0:
                continue
            for i in range(links[node, 0], links[node, 0] + links[node, 1]):
                d, a, b, c = _on_triangle(px, py, pz, corners[i])
                if d < best:
                    best, x, y, z, found = d, a, b, c, i
        distance[q], row[q] = np.sqrt(best), found
        point[q, 0], point[q, 1], point[q, 2] = x, y, z
    return distance, point, row
