"""Growth of a region over a closed triangle mesh, face by face, steered by vertex degrees: coded, or read, as it goes.

The region is bounded by loops of gates, see `Boundary`. A new face lies across a gate from node a to node b; its third vertex
is one of three:

    the vertex before a or after b, where a or b misses this face alone: no bit is sent        `_close_vertex`
    one that the region has not met: a bit, and its degree                                     `_attach_new_vertex`
    one on this loop or on another: a bit, which one, and on which side its faces are missing  `_attach_old_vertex`

The last case splits a loop in two, or joins two loops to one. Each function both writes and reads, as those of `range_coder`
do; what only the sender knows is in `ClosedMesh`, and half-edges are negative on the receiver's side. Degree-driven
coding of this kind: Touma and Gotsman 1998; gates by the fewest missing faces: Alliez and Desbrun 2001.
"""
from ..jit import njit
from .boundary import (
    ALL_FACES,
    DUMMIES,
    FACES,
    LENGTH,
    NODES,
    PIVOT,
    SCAN,
    STEPS,
    VERTICES,
    WAITING,
    add_candidates,
    drop_waiting,
    find_old,
    least_missing,
    link,
    loop_length,
    next_face,
    next_halfedge,
)
from .degree_coding import code_degree, code_is_old
from .range_coder import ENCODE, MODE, code_bit, code_uniform, code_unsigned

_DUMMY, _OTHER = 0, 2       # rows of the coder's contexts
CONTEXTS, MIXERS = 3, 4


@njit
def _degree_of(boundary, name):
    """Degree of a vertex by its number, 0 for a dummy's -1."""
    return boundary.degree[name] if name >= 0 else 0


@njit
def _surroundings(boundary, around, a, b):
    """What is known about the gate from node a to node b: missing faces and degrees, into `around`, see `degree_coding`."""
    name, missing = boundary.name, boundary.missing
    around[0], around[1] = max(missing[a], 1), max(missing[b], 1)
    around[2], around[3] = max(missing[boundary.before[a]], 1), max(missing[boundary.after[b]], 1)
    around[4], around[5] = _degree_of(boundary, name[a]), _degree_of(boundary, name[b])
    around[6] = _degree_of(boundary, boundary.apex[a])
    around[7] = boundary.state[LENGTH]


@njit
def _start_component(coder, mixer, around, boundary, mesh, numbering, start):
    """Code the first face of a component: three new vertices. start: the half-edge at which the very first begins (sender).

    Returns False if the data cannot be a mesh.
    """
    state = boundary.state
    sending, node, made = coder.rc[MODE] == ENCODE, state[NODES], state[FACES]
    if node + 3 > len(boundary.name) or made == state[ALL_FACES]:
        return False
    h, degree = start, 0
    if sending and made > 0:
        while mesh.done[state[SCAN]]:
            state[SCAN] += 1
        h = 3 * state[SCAN]
    if sending:
        numbering.halfedge_of[made] = h
        mesh.done[h // 3] = True
    around[:] = 0
    for k in range(3):
        vertex = state[VERTICES]
        around[1] = k
        if sending:
            mesh.seen[mesh.origin[h]] = True
            degree = mesh.degree[mesh.origin[h]]
            numbering.vertex_of[vertex] = mesh.origin[h]
        degree = code_degree(coder, mixer, degree, around)
        boundary.degree[vertex] = degree
        boundary.name[node + k], boundary.missing[node + k], numbering.faces[made, k] = vertex, degree - 1, vertex
        link(boundary, mesh, node + k, node + (k + 1) % 3, h if sending else -1, vertex - k + (k + 2) % 3)
        h = next_halfedge(h)
        state[VERTICES] += 1
    boundary.waiting[0], state[WAITING] = node, 1
    state[NODES] += 3
    state[FACES] += 1
    return True


@njit
def _close_vertex(boundary, mesh, face):
    """Join the neighbours of a or b, which misses no face any more; returns the third node, or -1 if that cannot be."""
    missing, state = boundary.missing, boundary.state
    a, b = face.a, face.b
    closes_b = missing[b] == 0
    c = boundary.after[b] if closes_b else boundary.before[a]
    missing[c] -= 1
    if state[LENGTH] == 3:
        state[LENGTH] = 0
        return c if missing[a] == 0 and missing[b] == 0 and missing[c] == 0 else -1
    state[LENGTH] -= 1
    if closes_b:
        link(boundary, mesh, a, c, face.ac, boundary.name[b])
        if missing[a] == 0 or missing[c] == 0:
            return -1
        if state[PIVOT] == b:
            state[PIVOT] = least_missing(boundary, a)
    else:
        link(boundary, mesh, c, b, face.cb, boundary.name[a])
        if missing[c] == 0:
            return -1
        if state[PIVOT] == a:
            state[PIVOT] = least_missing(boundary, c)
    return c


@njit
def _meets_old_vertex(coder, mixer, around, boundary, mesh, face):
    """Whether the third vertex is one that the region has met."""
    met = 1 if coder.rc[MODE] == ENCODE and mesh.seen[mesh.origin[face.cb]] else 0
    _surroundings(boundary, around, face.a, face.b)
    if boundary.state[LENGTH] > 4 or boundary.state[WAITING] > 0:
        met = code_is_old(coder, mixer, met, around)
    return met


@njit
def _attach_new_vertex(coder, mixer, around, boundary, mesh, numbering, face):
    """Put a vertex that the region has not met, or a dummy, between a and b; returns its node."""
    state, degree, dummy = boundary.state, 0, 0
    if coder.rc[MODE] == ENCODE:
        v = mesh.origin[face.cb]
        mesh.seen[v] = True
        degree, dummy = mesh.degree[v], mesh.is_dummy[v]
        if not dummy:
            numbering.vertex_of[state[VERTICES]] = v
    if state[DUMMIES] > 0:
        dummy = code_bit(coder, dummy, _DUMMY, _DUMMY, _DUMMY, 0)
        state[DUMMIES] -= dummy
    if dummy:
        degree = 3 + code_unsigned(coder, degree - 3, _DUMMY + 1, _DUMMY + 1, _DUMMY + 1, 1, 1)
    else:
        degree = code_degree(coder, mixer, degree, around)
        boundary.degree[state[VERTICES]] = degree
    c = state[NODES]
    boundary.name[c], boundary.missing[c] = -1 if dummy else state[VERTICES], degree - 1
    link(boundary, mesh, face.a, c, face.ac, boundary.name[face.b])
    link(boundary, mesh, c, face.b, face.cb, boundary.name[face.a])
    state[NODES] += 1
    state[VERTICES] += 1 - dummy
    state[LENGTH] += 1
    return c


@njit
def _code_candidate(coder, boundary, c, here, every):
    """Index of node c among the candidates; the first `here` of the `every` are on the loop of the gate."""
    sending, first, last = coder.rc[MODE] == ENCODE, 0, every
    if here > 0 and every > here:
        other = 1
        for t in range(here):
            if boundary.candidates[t] == c:
                other = 0
        if code_bit(coder, other, _OTHER, _OTHER, _OTHER, 2):
            first = here
        else:
            last = here
    index = 0
    while sending and boundary.candidates[first + index] != c:
        index += 1
    return first + code_uniform(coder, index, last - first)


@njit
def _attach_old_vertex(coder, boundary, mesh, face):
    """Join the gate to a node c of this loop, which splits in two, or of one that waits, which becomes a part of this one.

    c keeps a's side; a second node of the same vertex takes b's side. Returns c, or -1 if there is no such node.
    """
    state, missing = boundary.state, boundary.missing
    a, b = face.a, face.b
    c, between = -1, 0
    if coder.rc[MODE] == ENCODE:
        c, between = find_old(boundary, mesh, face.cb)
    here = add_candidates(boundary, boundary.after[boundary.after[b]], state[LENGTH] - 4, 0)
    every = here
    for t in range(state[WAITING]):
        loop = boundary.waiting[t]
        every = add_candidates(boundary, loop, loop_length(boundary, loop), every)
    if every == 0:
        return -1
    index = _code_candidate(coder, boundary, c, here, every)
    c = boundary.candidates[index]
    between = 1 + code_uniform(coder, between - 1, missing[c] - 2)
    second, into = state[NODES], boundary.before[c]
    boundary.name[second], missing[second] = boundary.name[c], between
    missing[c] -= 1 + between
    link(boundary, mesh, into, second, boundary.gate[into], boundary.apex[into])
    link(boundary, mesh, a, c, face.ac, boundary.name[b])
    link(boundary, mesh, second, b, face.cb, boundary.name[a])
    state[NODES] += 1
    if index < here:
        boundary.waiting[state[WAITING]] = b
        state[WAITING] += 1
    else:
        drop_waiting(boundary, c)
    state[LENGTH] = loop_length(boundary, a)
    return c


@njit
def _add_face(coder, mixer, around, boundary, mesh, numbering):
    """Add the next face to the region. Returns False if the data cannot be a mesh."""
    state, name, missing = boundary.state, boundary.name, boundary.missing
    if state[NODES] + 2 > len(name) or state[STEPS] < 0:
        return False
    face = next_face(boundary, mesh, coder.rc[MODE] == ENCODE)
    a, b = face.a, face.b
    missing[a] -= 1
    missing[b] -= 1
    if missing[a] == 0 or missing[b] == 0:
        c = _close_vertex(boundary, mesh, face)
    elif _meets_old_vertex(coder, mixer, around, boundary, mesh, face):
        c = _attach_old_vertex(coder, boundary, mesh, face)
    else:
        c = _attach_new_vertex(coder, mixer, around, boundary, mesh, numbering, face)
    if c < 0:
        return False
    if name[a] >= 0 and name[b] >= 0 and name[c] >= 0:  # else the face is one of a dummy's
        row = state[FACES]
        if row == state[ALL_FACES]:
            return False
        numbering.faces[row, 0], numbering.faces[row, 1], numbering.faces[row, 2] = name[b], name[a], name[c]
        if face.ba >= 0:
            numbering.halfedge_of[row] = face.ba
        state[FACES] += 1
    return True


@njit
def grow(coder, mixer, around, boundary, mesh, numbering, start):
    """Code all components; returns the number of vertices, or -1 if the data cannot be a mesh.

    boundary: a `new_boundary`; start: half-edge at which the first face begins (sender); the result is in `numbering`.
    """
    state = boundary.state
    for _ in range(len(boundary.name)):
        if state[WAITING] == 0:
            if state[FACES] == state[ALL_FACES]:
                return state[VERTICES]
            if not _start_component(coder, mixer, around, boundary, mesh, numbering, start):
                return -1
        state[WAITING] -= 1
        loop = boundary.waiting[state[WAITING]]
        state[PIVOT] = least_missing(boundary, loop)
        state[LENGTH] = loop_length(boundary, loop)
        while state[LENGTH] > 0:
            if not _add_face(coder, mixer, around, boundary, mesh, numbering):
                return -1
    return -1
