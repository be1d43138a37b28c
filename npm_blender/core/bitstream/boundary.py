"""Boundary loops of a region that grows over a closed triangle mesh: what `region_growing` knows, and steps along them."""
from typing import NamedTuple

import numpy as np

from ..jit import njit

# scalars of a boundary, indices into `Boundary.state`: nodes made; loops that wait; vertices and faces found; faces to find;
# dummies to come; of the loop being closed its length and its pivot, the node with the fewest missing faces; the sender's
# first face that may be outside the region; steps along loops that are still allowed
NODES, WAITING, VERTICES, FACES, ALL_FACES, DUMMIES, LENGTH, PIVOT, SCAN, STEPS = range(10)
_LOOK_AHEAD = 64            # nodes among which a pivot is sought
_STEPS_A_FACE, _STEPS = 256, 1 << 18  # along loops: what real meshes need is far below


class Boundary(NamedTuple):
    """Boundary loops of the region. A node is one visit of a loop to a vertex; the first six arrays are indexed by node.

    name: new number of its vertex, -1 for a dummy; missing: faces still missing in its sector; after, before: its loop;
    gate: half-edge from it to the next node, in a face of the region (sender only); apex: number of the third vertex of that
    face, -1 for a dummy; degree: by number of vertex; waiting: a stack, one node of each loop that waits; candidates: room
    for `_attach_old_vertex`; state (10,): scalars, see NODES. All int64.
    """

    name: np.ndarray
    missing: np.ndarray
    after: np.ndarray
    before: np.ndarray
    gate: np.ndarray
    apex: np.ndarray
    degree: np.ndarray
    waiting: np.ndarray
    candidates: np.ndarray
    state: np.ndarray


class ClosedMesh(NamedTuple):
    """The closed mesh as the sender sees it (empty arrays on the receiver's side), with its marks. All int64.

    opposite, origin per half-edge; degree, is_dummy per vertex; node_of: boundary node of a half-edge; seen: vertices
    that have appeared; done: faces in the region.
    """

    opposite: np.ndarray
    origin: np.ndarray
    degree: np.ndarray
    is_dummy: np.ndarray
    node_of: np.ndarray
    seen: np.ndarray
    done: np.ndarray


class Numbering(NamedTuple):
    """What the growth finds. faces (m, 3) in the new numbering; sender only: vertex_of, old vertex of each new one, and
    halfedge_of, old half-edge at which each new face begins. All int64."""

    faces: np.ndarray
    vertex_of: np.ndarray
    halfedge_of: np.ndarray


class NewFace(NamedTuple):
    """The face across a gate: nodes a and b of the gate, and its half-edges b -> a, a -> c and c -> b, c its third vertex."""

    a: int
    b: int
    ba: int
    ac: int
    cb: int


@njit
def next_halfedge(h):
    """The next half-edge in the face of h; negative for a negative one."""
    return h // 3 * 3 + (h + 1) % 3


@njit
def link(boundary, mesh, i, j, h, apex):
    """Make j the node after i, across a gate on half-edge h of a face whose third vertex is number `apex`."""
    boundary.after[i], boundary.before[j], boundary.gate[i], boundary.apex[i] = j, i, h, apex
    if h >= 0:
        mesh.node_of[h] = i


@njit
def loop_length(boundary, i):
    """Nodes of the loop that holds node i."""
    length, j = 1, boundary.after[i]
    while j != i:
        length += 1
        j = boundary.after[j]
    boundary.state[STEPS] -= length
    return length


@njit
def least_missing(boundary, i):
    """The first node with the fewest missing faces among node i and those after it, 64 of its loop at most."""
    best, j = i, boundary.after[i]
    for _ in range(_LOOK_AHEAD - 1):
        if j == i:
            break
        if boundary.missing[j] < boundary.missing[best]:
            best = j
        j = boundary.after[j]
    return best


@njit
def add_candidates(boundary, first, length, count):
    """Append to candidates[count:] those of the `length` nodes from `first` on that can be joined; returns the new count."""
    for _ in range(length):
        if boundary.missing[first] >= 3:
            boundary.candidates[count] = first
            count += 1
        first = boundary.after[first]
    boundary.state[STEPS] -= length
    return count


@njit
def find_old(boundary, mesh, cb):
    """Node at which the new face's half-edge c -> b meets a boundary, and the missing faces from there to b."""
    between, h = 0, mesh.opposite[cb]
    while not mesh.done[h // 3]:
        between += 1
        h = mesh.opposite[next_halfedge(h)]
    return boundary.after[mesh.node_of[h]], between


@njit
def drop_waiting(boundary, i):
    """Take the loop that holds node i off the stack."""
    state, waiting = boundary.state, boundary.waiting
    for t in range(state[WAITING]):
        j = boundary.after[waiting[t]]
        while j != waiting[t] and j != i:
            state[STEPS] -= 1
            j = boundary.after[j]
        if j == i:
            state[WAITING] -= 1
            waiting[t] = waiting[state[WAITING]]
            return


@njit
def next_face(boundary, mesh, sending):
    """The face to add: across the gate at the pivot, or across the one before it whose end misses this face alone."""
    a = boundary.state[PIVOT]
    left = boundary.before[a]
    if boundary.missing[a] > 1 and boundary.missing[boundary.after[a]] > 1 and boundary.missing[left] == 1:
        a = boundary.before[left]
    ba = -1
    if sending:
        ba = mesh.opposite[boundary.gate[a]]
        mesh.done[ba // 3] = True
    ac = next_halfedge(ba)
    return NewFace(a, boundary.after[a], ba, ac, next_halfedge(ac))


def new_boundary(faces: int, dummies: int) -> Boundary:
    """An empty region that is to have so many faces, and so many dummy vertices beside it."""
    room, state = 8 * faces + 32, np.zeros(10, np.int64)
    state[ALL_FACES], state[DUMMIES], state[STEPS] = faces, dummies, _STEPS + _STEPS_A_FACE * faces
    return Boundary._make([*(np.zeros(room, np.int64) for _ in range(9)), state])
