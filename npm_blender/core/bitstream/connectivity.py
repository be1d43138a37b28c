"""Connectivity of the base mesh as a few bits per face: region growing steered by vertex degrees.

The region starts as one face and grows by one face at a time across a gate a -> b of its boundary loop. Both sides
know how many faces every boundary vertex still misses (its degree is sent when it first appears), so a face that
completes a or b costs nothing; otherwise its third vertex is new (the usual case: its degree is sent), or one already
on a boundary (rare: which one, and how its missing faces split between the two sides). Borders are closed by one
dummy vertex per border loop, which the receiver drops again; so any genus, borders and components come for free.
Degree-driven coding of this kind: Touma and Gotsman 1998, Alliez and Desbrun 2001.
"""
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..errors import MeshError, StreamError
from ..jit import njit
from ..mesh import component_labels, opposite_halfedges, vertex_fans
from .range_coder import (
    ENCODE,
    MODE,
    code_bit,
    code_uniform,
    code_unsigned,
    finish_encoding,
    new_contexts,
    new_weights,
    range_decoder,
    range_encoder,
)
from .varint import read_varint, write_varint

if TYPE_CHECKING:
    from ..mesh import Renumbering

MAX_FACES = 1 << 18         # of a base mesh
_DEGREE_STEPS = 12          # degrees 3..14 by context, above by Exp-Golomb
_FIT = 8                    # missing-face counts are contexts 1..8
_SPLIT, _DUMMY, _OTHER, _DEGREE = 0, 200, 210, 220
_CONTEXTS = _DEGREE + (2 * _FIT * _FIT + 2 * _FIT) * _DEGREE_STEPS + 4 * _DEGREE_STEPS
_MIXERS = 40


def _models() -> tuple[np.ndarray, np.ndarray]:
    return new_contexts(_CONTEXTS, 127), new_weights(_MIXERS)


@njit
def _code_degree(coder, degree, first, second):
    """Degree of a new vertex, given the missing faces of the gate's ends (0, 0 at the start of a component)."""
    first, second = min(first, _FIT - 1), min(second, _FIT - 1)
    i = _DEGREE + (first * _FIT + second) * _DEGREE_STEPS
    j = _DEGREE + (_FIT * _FIT + first) * _DEGREE_STEPS
    k = _DEGREE + (_FIT * _FIT + 2 * _FIT) * _DEGREE_STEPS
    return 3 + code_unsigned(coder, degree - 3, i, j, k, 0, _DEGREE_STEPS)


class _Boundary(NamedTuple):
    """Boundary loops of the region. A node is one visit of a loop to a vertex; arrays are indexed by node.

    name: new number of its vertex, -1 for a dummy; missing: faces still missing in its sector; after, before: its loop;
    gate: half-edge from it to the next node, in a face of the region (encoder only).
    """

    name: np.ndarray
    missing: np.ndarray
    after: np.ndarray
    before: np.ndarray
    gate: np.ndarray


class _Closed(NamedTuple):
    """The closed mesh as the encoder sees it (empty arrays in the decoder), with its marks.

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


@njit
def _link(edge, closed, i, j, g):
    """Make j the node after i, across a gate on half-edge g."""
    edge.after[i], edge.before[j], edge.gate[i] = j, i, g
    if g >= 0:
        closed.node_of[g] = i


@njit
def _loop_length(edge, i):
    length, j = 1, edge.after[i]
    while j != i:
        length += 1
        j = edge.after[j]
    return length


@njit
def _least_missing(edge, i):
    """The first node at or after i with the fewest missing faces in its loop."""
    best, j = i, edge.after[i]
    while j != i:
        if edge.missing[j] < edge.missing[best]:
            best = j
        j = edge.after[j]
    return best


@njit
def _candidates(edge, first, length, pool, count):
    """Append to pool[count:] those of the `length` nodes from `first` on that can be joined; returns the new count."""
    for _ in range(length):
        if edge.missing[first] >= 3:
            pool[count] = first
            count += 1
        first = edge.after[first]
    return count


@njit
def _find_old(edge, closed, gb):
    """Node at which the new face's half-edge gb = c -> b meets a boundary, and the missing faces from there to b."""
    between, i = 0, closed.opposite[gb]
    while not closed.done[i // 3]:
        between += 1
        i = closed.opposite[i // 3 * 3 + (i + 1) % 3]
    return edge.after[closed.node_of[i]], between


@njit
def _drop_waiting(edge, loops, waiting, i):
    """Take the loop that holds node i off the stack; returns how many still wait."""
    for t in range(waiting):
        j = edge.after[loops[t]]
        while j != loops[t] and j != i:
            j = edge.after[j]
        if j == i:
            loops[t] = loops[waiting - 1]
            return waiting - 1
    return waiting


@njit
def _choose_gate(edge, pivot):
    """First node of the gate to cross: one whose end misses a single face, if it touches the pivot, else the pivot."""
    left = edge.before[pivot]
    if edge.missing[pivot] > 1 and edge.missing[edge.after[pivot]] > 1 and edge.missing[left] == 1:
        return edge.before[left]
    return pivot


@njit
def _grow(coder, faces, dummies, closed, start, out, vertex_of, halfedge_of):
    """Code all components; returns the number of vertices, or -1 if the data cannot be a mesh.

    faces, dummies: how many to expect. start: half-edge at which the first face begins (encoder).
    Outputs: out (faces, 3) faces in the new numbering; encoder only: vertex_of, old vertex of each new one, and
    halfedge_of, old half-edge at which each new face begins.
    """
    sending = coder.rc[MODE] == ENCODE
    room = 8 * faces + 32
    edge = _Boundary(np.zeros(room, np.int64), np.zeros(room, np.int64), np.zeros(room, np.int64),
                     np.zeros(room, np.int64), np.zeros(room, np.int64))
    name, missing, after, before, gate = edge
    loops = np.zeros(room, np.int64)            # stack: one node of each boundary loop that waits
    pool = np.zeros(room, np.int64)
    nodes, waiting, found, made, scan = 0, 0, 0, 0, 0
    for _ in range(room):
        if waiting == 0:
            # the first face of a component: three new vertices
            if made == faces:
                return found
            h, d = start, 0
            if sending and made > 0:
                while closed.done[scan]:
                    scan += 1
                h = 3 * scan
            for k in range(3):
                if sending:
                    closed.done[h // 3] = True
                    closed.seen[closed.origin[h]] = True
                    d = closed.degree[closed.origin[h]]
                    vertex_of[found] = closed.origin[h]
                    if k == 0:
                        halfedge_of[made] = h
                d = _code_degree(coder, d, 0, k)
                name[nodes + k], missing[nodes + k], out[made, k] = found, d - 1, found
                _link(edge, closed, nodes + k, nodes + (k + 1) % 3, h if sending else -1)
                h = h // 3 * 3 + (h + 1) % 3
                found += 1
            loops[0], waiting, made, nodes = nodes, 1, made + 1, nodes + 3
        waiting -= 1
        pivot = _least_missing(edge, loops[waiting])
        length = _loop_length(edge, pivot)
        while length > 0:
            a = _choose_gate(edge, pivot)
            b = after[a]
            g, ga, gb = -1, -1, -1              # the new face's half-edges b -> a, a -> c, c -> b
            if sending:
                g = closed.opposite[gate[a]]
                ga, gb = g // 3 * 3 + (g + 1) % 3, g // 3 * 3 + (g + 2) % 3
                closed.done[g // 3] = True
            if nodes + 2 > room:
                return -1
            missing[a] -= 1
            missing[b] -= 1
            if missing[a] == 0 or missing[b] == 0:
                c = after[b] if missing[b] == 0 else before[a]
                missing[c] -= 1
                if length == 3:
                    if missing[a] != 0 or missing[b] != 0 or missing[c] != 0:
                        return -1
                    length = 0
                elif missing[b] == 0:
                    _link(edge, closed, a, c, ga)
                    if missing[a] == 0 or missing[c] == 0:
                        return -1
                    length -= 1
                    pivot = pivot if pivot != b else _least_missing(edge, a)
                else:
                    _link(edge, closed, c, b, gb)
                    if missing[c] == 0:
                        return -1
                    length -= 1
                    pivot = pivot if pivot != a else _least_missing(edge, c)
            else:
                split, c, between = 0, -1, 0
                if sending and closed.seen[closed.origin[gb]]:
                    split = 1
                    c, between = _find_old(edge, closed, gb)
                if length > 4 or waiting > 0:
                    near, far = min(missing[before[a]], _FIT) - 1, min(missing[after[b]], _FIT) - 1
                    i = _SPLIT + (min(missing[a], _FIT) - 1) * _FIT + min(missing[b], _FIT) - 1
                    j, k = _SPLIT + 64 + near * _FIT + far, _SPLIT + 128 + min(length, 71)
                    split = code_bit(coder, split, i, j, k, 30)
                if split == 0:
                    d, fake = 0, 0
                    if sending:
                        v = closed.origin[gb]
                        closed.seen[v] = True
                        d, fake = closed.degree[v], closed.is_dummy[v]
                        if not fake:
                            vertex_of[found] = v
                    if dummies > 0:
                        fake = code_bit(coder, fake, _DUMMY, _DUMMY, _DUMMY, 31)
                        dummies -= fake
                    if fake:
                        d = 3 + code_unsigned(coder, d - 3, _DUMMY + 1, _DUMMY + 1, _DUMMY + 1, 32, 1)
                    else:
                        d = _code_degree(coder, d, missing[a], missing[b])
                    c = nodes
                    nodes += 1
                    name[c], missing[c] = -1 if fake else found, d - 1
                    found += 1 - fake
                    _link(edge, closed, a, c, ga)
                    _link(edge, closed, c, b, gb)
                    length += 1
                else:
                    # old vertices that could be joined: first those of this loop, then those of the loops that wait
                    here = _candidates(edge, after[after[b]], length - 4, pool, 0)
                    every = here
                    for t in range(waiting):
                        every = _candidates(edge, loops[t], _loop_length(edge, loops[t]), pool, every)
                    if every == 0:
                        return -1
                    first, last = 0, every
                    if here > 0 and every > here:
                        other = 1
                        for t in range(here):
                            if pool[t] == c:
                                other = 0
                        if code_bit(coder, other, _OTHER, _OTHER, _OTHER, 33):
                            first = here
                        else:
                            last = here
                    index = 0
                    while sending and pool[first + index] != c:
                        index += 1
                    index = first + code_uniform(coder, index, last - first)
                    c = pool[index]
                    between = 1 + code_uniform(coder, between - 1, missing[c] - 2)
                    # c keeps a's side, a second node of the same vertex takes b's side
                    twin, into = nodes, before[c]
                    nodes += 1
                    name[twin], missing[twin] = name[c], between
                    missing[c] -= 1 + between
                    _link(edge, closed, into, twin, gate[into])
                    _link(edge, closed, a, c, ga)
                    _link(edge, closed, twin, b, gb)
                    if index < here:
                        loops[waiting] = b
                        waiting += 1
                    else:
                        waiting = _drop_waiting(edge, loops, waiting, c)
                    length = _loop_length(edge, a)
            if name[a] >= 0 and name[b] >= 0 and name[c] >= 0:
                if made == faces:
                    return -1
                out[made, 0], out[made, 1], out[made, 2] = name[b], name[a], name[c]
                if sending:
                    halfedge_of[made] = g
                made += 1
    return -1


def _close(F: np.ndarray, n: int) -> tuple[_Closed, int]:
    """F (m, 3) with every border loop closed by a fan round a dummy vertex n, n + 1, ..; and the number of loops."""
    opposite = opposite_halfedges(F)
    fans = vertex_fans(F, opposite, n)
    if (fans == 0).any():
        raise MeshError(f"Expected every base vertex to have a face, found {int((fans == 0).sum())} isolated vertices; "
                        "remove them first")
    if (fans > 1).any():
        raise MeshError(f"Expected a manifold base mesh, found {int((fans > 1).sum())} vertices where parts of the "
                        "surface touch in a point; clean the mesh first (--clean auto)")
    h = np.flatnonzero(opposite == np.arange(F.size))
    tail, tip = F.reshape(-1)[h], F.reshape(-1)[h // 3 * 3 + (h + 1) % 3]
    roots, loop = np.unique(component_labels(n, tail, tip)[tail], return_inverse=True)
    whole = np.concatenate([F, np.stack([tip, tail, n + loop.reshape(-1)], 1)]).astype(np.int64)
    degree = np.bincount(whole.reshape(-1), minlength=n + len(roots))
    if (degree < 3).any():
        raise MeshError("Expected at least three faces round an inner vertex, found two; the mesh has a collapsed part")
    return _Closed(
        opposite=opposite_halfedges(whole).astype(np.int64), origin=whole.reshape(-1), degree=degree.astype(np.int64),
        is_dummy=(np.arange(len(degree)) >= n).astype(np.int64), node_of=np.full(whole.size, -1, np.int64),
        seen=np.zeros(len(degree), np.int64), done=np.zeros(len(whole), np.int64)), len(roots)


def _encode(F: np.ndarray, n: int, start: int) -> tuple[bytes, np.ndarray, np.ndarray, np.ndarray]:
    """Payload, new faces, old vertex of each new one, old half-edge of each new face."""
    F = np.ascontiguousarray(F, dtype=np.int64)
    if not 0 < len(F) <= MAX_FACES:
        raise MeshError(f"Expected a base mesh of 1 to {MAX_FACES} faces, found {len(F)}; choose fewer base faces")
    closed, borders = _close(F, n)
    out, vertex_of, halfedge_of = np.zeros_like(F), np.zeros(n, np.int64), np.zeros(len(F), np.int64)
    coder = range_encoder(*_models(), capacity=64 + 40 * len(closed.done))
    found = _grow(coder, len(F), borders, closed, start, out, vertex_of, halfedge_of)
    if found != n:  # every manifold is covered: a bug, not an input
        raise RuntimeError(f"region growing covered {found} of {n} vertices")
    return write_varint(len(F)) + write_varint(borders) + finish_encoding(coder), out, vertex_of, halfedge_of


def canonical_order(F0: np.ndarray, n0: int) -> "Renumbering":
    """The order in which the receiver will see the base faces F0 (m, 3) over n0 vertices.

    Encoding and decoding the result's F gives exactly that F back: faces, corner rotation and numbering. Idempotent.
    Raises MeshError if F0 is not an oriented manifold, has isolated vertices, or more than MAX_FACES faces.
    """
    from ..mesh import Renumbering

    _, out, vertex_of, halfedge_of = _encode(F0, n0, 0)
    return Renumbering(vertex_of.astype(np.int32), (halfedge_of // 3).astype(np.int32), out.astype(np.int32))


def encode_connectivity(F: np.ndarray) -> bytes:
    """Bytes of the faces F (m, 3) of a `canonical_order`. Raises MeshError in another order, or as that does."""
    F = np.asarray(F)
    data, out, _, _ = _encode(F, int(F.max()) + 1 if F.size else 0, 0)
    if not np.array_equal(out, F):
        raise MeshError("Expected base faces in canonical order, found another; call canonical_order first")
    return data


def decode_connectivity(data: bytes) -> np.ndarray:
    """Faces (m, 3) int32 of `encode_connectivity`'s bytes. Raises StreamError if the bytes are not such a mesh."""
    try:
        faces, at = read_varint(data, 0)
        borders, at = read_varint(data, at)
    except EOFError:
        raise StreamError("Expected the counts of the base mesh, found no data; the file is corrupted") from None
    if not (0 < faces <= MAX_FACES and borders <= faces):
        raise StreamError(f"Expected a base mesh of 1 to {MAX_FACES} faces, found {faces} faces and {borders} borders; "
                          "the file is corrupted")
    nothing = np.zeros(0, np.int64)
    closed = _Closed(nothing, nothing, nothing, nothing, nothing, nothing, nothing)
    out = np.zeros((faces, 3), np.int64)
    found = _grow(range_decoder(*_models(), data[at:]), faces, borders, closed, 0, out, nothing, nothing)
    try:
        if found < 3:
            raise MeshError("faces do not close up")
        opposite_halfedges(out)
    except MeshError as e:
        raise StreamError("Expected a manifold base mesh, found faces that do not close up; the file is corrupted") from e
    return out.astype(np.int32)
