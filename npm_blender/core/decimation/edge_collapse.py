"""The collapse of an edge in a half-edge mesh: its stencil, the condition that it keeps the topology, and the change itself."""
from ..geometry import next_halfedge, prev_halfedge
from ..jit import compiled
from ..parameterization import ANCHORED, EDGE, INNER, Stencil


@compiled
def _append_fan(m, h, stop, ring, faces, r, t):
    """Append the faces round the start of h, counter-clockwise, until the half-edge `stop` or the border."""
    while h != stop:
        ring[r] = m.corner[next_halfedge(h)]
        faces[t] = h // 3 * 4 + h % 3
        r += 1
        t += 1
        p = prev_halfedge(h)
        h = m.opposite[p]
        if h == p:
            ring[r] = m.corner[p]
            r += 1
            break
    return r, t


@compiled(inline="always", allocates=True)  # returns the arrays that it is given
def gather_stencil(m, h, kind, ring, faces):
    """The stencil of the collapse along half-edge h, from i to j.

    m: a HalfedgeMesh; kind: INNER, ANCHORED or EDGE, and i is the end on the border where only one is; ring, faces int32: arrays
    that the stencil takes, with room for the faces of both ends and SPARE more. See `Stencil` for what is where (ours).

    >>> import numpy as np
    >>> from npm_blender.core.decimation import gather_stencil, half_edges_with_quadrics
    >>> from npm_blender.core.mesh import TriMesh
    >>> from npm_blender.core.parameterization import INNER
    >>> V = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    >>> octahedron = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    >>> m, _ = half_edges_with_quadrics(TriMesh.from_arrays(V, octahedron))
    >>> stencil = gather_stencil(m, 0, INNER, np.zeros(16, np.int32), np.zeros(16, np.int32))  # along half-edge 0: 0 -> 2
    >>> stencil.ring[:stencil.ring_size].tolist(), (stencil.faces[:stencil.sides] // 4).tolist()
    ([5, 1, 4, 3], [5, 1, 3, 7])
    >>> int(stencil.j_start), int(stencil.j_stop)  # faces 5 and 1 are those of vertex 2
    (0, 2)
    """
    o = m.opposite[h]
    i, j = m.corner[h], m.corner[next_halfedge(h)]
    r = t = j_start = 0
    if kind == INNER:
        r, t = _append_fan(m, m.opposite[prev_halfedge(o)], next_halfedge(h), ring, faces, r, t)
        j_stop = r
        r, t = _append_fan(m, m.opposite[prev_halfedge(h)], next_halfedge(o), ring, faces, r, t)
    else:
        if kind == ANCHORED:
            r, t = _append_fan(m, m.out[i], next_halfedge(o), ring, faces, r, t)
            j_start = r
            r, t = _append_fan(m, m.opposite[prev_halfedge(o)], next_halfedge(h), ring, faces, r, t)
        else:
            r, t = _append_fan(m, m.out[j], next_halfedge(h), ring, faces, r, t)
        j_stop = r
        p = prev_halfedge(h)
        if m.opposite[p] == p:
            ring[r] = m.corner[p]
            r += 1
        else:
            r, t = _append_fan(m, m.opposite[p], -1, ring, faces, r, t)
    faces[t] = h // 3 * 4 + h % 3
    if kind != EDGE:
        faces[t + 1] = o // 3 * 4 + o % 3
    return Stencil(kind, ring, faces, r, t, j_start, j_stop, i, j)


@compiled(inline="always")
def link_condition_holds(stencil):
    """Whether the collapse of a stencil keeps the topology of the mesh: the link condition (Dey et al. 1999).

    link(i) and link(j) may meet only in link(i j): i and j have no neighbours in common but the third vertices of the faces on
    the edge. That holds where no vertex comes twice in the ring.

    >>> import numpy as np
    >>> from npm_blender.core.decimation import gather_stencil, half_edges_with_quadrics, link_condition_holds
    >>> from npm_blender.core.mesh import TriMesh
    >>> from npm_blender.core.parameterization import INNER
    >>> V = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    >>> octahedron = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    >>> m, _ = half_edges_with_quadrics(TriMesh.from_arrays(V, octahedron))
    >>> stencil = gather_stencil(m, 0, INNER, np.zeros(16, np.int32), np.zeros(16, np.int32))  # along half-edge 0: 0 -> 2
    >>> bool(link_condition_holds(stencil))
    True
    >>> stencil.ring[3] = stencil.ring[0]  # a neighbour of both ends that is on no face with both
    >>> bool(link_condition_holds(stencil))
    False
    """
    ring, ring_size = stencil.ring, stencil.ring_size
    for q in range(stencil.j_start, min(stencil.j_stop + 1, ring_size)):
        for p in range(ring_size):
            if ring[p] == ring[q] and p != q:
                return False
    return True


@compiled
def _stitch(m, gone, kept):
    """Close the gap that a vanished face leaves between its sides `gone` (at j) and `kept` (at i).

    Returns the edge that vanishes; afterwards the edge of `kept` is the one from i to the third vertex.
    """
    x, y = m.opposite[gone], m.opposite[kept]
    e = m.edge[kept]
    inner_x, inner_y = x != gone, y != kept
    if inner_x:
        m.opposite[x] = y if inner_y else x
        m.edge[x] = e
        m.start[e] = x
    if inner_y:
        m.opposite[y] = x if inner_x else y
        m.start[e] = y
    return m.edge[gone]


@compiled
def collapse_edge(m, h, stencil, point, dead):
    """Collapse the edge of half-edge h: i -> j, so that both become i at a point (Hoppe 1996); changes the mesh m in place.

    stencil: that of h, from `gather_stencil`; point: a tuple x, y, z; dead (3,) int32 gets the edges that vanish, where the
    edge is on the border two of them and the first again. Returns the number of faces removed, 1 or 2. Their corners become -1.

    >>> import numpy as np
    >>> from npm_blender.core.decimation import collapse_edge, gather_stencil, half_edges_with_quadrics
    >>> from npm_blender.core.mesh import TriMesh
    >>> from npm_blender.core.parameterization import INNER
    >>> V = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    >>> octahedron = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    >>> m, _ = half_edges_with_quadrics(TriMesh.from_arrays(V, octahedron))
    >>> stencil = gather_stencil(m, 0, INNER, np.zeros(16, np.int32), np.zeros(16, np.int32))  # along half-edge 0: 0 -> 2
    >>> int(collapse_edge(m, 0, stencil, (0.5, 0.5, 0.0), np.zeros(3, np.int32)))
    2
    >>> [f for f in m.corner.reshape(-1, 3).tolist() if f[0] >= 0]  # vertex 2 is gone, 0 has its faces
    [[0, 1, 4], [1, 3, 4], [3, 0, 4], [1, 0, 5], [3, 1, 5], [0, 3, 5]]
    """
    kind, faces = stencil.kind, stencil.faces
    o = m.opposite[h]
    i, j = m.corner[h], m.corner[next_halfedge(h)]
    n1, p1 = next_halfedge(h), prev_halfedge(h)
    a = m.corner[p1]
    x1, y1 = m.opposite[n1], m.opposite[p1]
    next_border = m.out[j]
    for q in range(stencil.j_start, stencil.j_stop):
        m.corner[faces[q] // 4 * 3 + faces[q] % 4] = i
    dead[0] = m.edge[h]
    dead[1] = _stitch(m, n1, p1)
    if m.out[a] == p1:
        m.out[a] = x1
    removed = 1
    if kind == EDGE:
        m.out[i] = y1 if next_border == n1 else next_border
        dead[2] = dead[0]
    else:
        n2, p2 = next_halfedge(o), prev_halfedge(o)
        b = m.corner[p2]
        x2, y2 = m.opposite[p2], m.opposite[n2]
        dead[2] = _stitch(m, p2, n2)
        if m.out[b] == p2:
            m.out[b] = y2
        if kind == INNER:
            m.out[i] = y1
        elif m.out[i] == n2:
            m.out[i] = x2
        m.valence[b] -= 1
        for k in range(3):
            m.corner[o // 3 * 3 + k] = -1
        removed = 2
    m.valence[a] -= 1
    for k in range(3):
        m.corner[h // 3 * 3 + k] = -1
    m.valence[i] = stencil.sides
    m.valence[j] = 0
    m.out[j] = -1
    m.X[i, 0], m.X[i, 1], m.X[i, 2] = point
    return removed
