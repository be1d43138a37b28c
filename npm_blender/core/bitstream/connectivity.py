"""Connectivity of the base mesh as a few bits per face: region growing steered by vertex degrees, see `region_growing`.

The region starts as one face and grows by one face at a time across a gate a -> b of its boundary loop. Both sides
know how many faces every boundary vertex still misses (its degree is sent when it first appears), so a face that
completes a or b costs nothing; otherwise its third vertex is new (the usual case: its degree is sent), or one already
on a boundary (rare: which one, and how its missing faces split between the two sides). Borders are closed by one
dummy vertex per border loop, which the receiver drops again; so any genus, borders and components come for free.
Degree-driven coding of this kind: Touma and Gotsman 1998, Alliez and Desbrun 2001.
"""
from typing import NamedTuple

import numpy as np

from ..errors import MeshError, StreamError
from ..mesh import Renumbering, component_labels, opposite_halfedges, vertex_fans
from .boundary import ClosedMesh, Numbering, new_boundary
from .degree_coding import new_degree_mixer, new_surroundings
from .range_coder import finish_encoding, new_contexts, new_weights, range_decoder, range_encoder
from .region_growing import CONTEXTS, MIXERS, grow
from .varint import read_varint, write_varint

MAX_FACES = 1 << 18         # of a base mesh


class OrderedConnectivity(NamedTuple):
    """A base mesh as its receiver will see it: order, the renumbering; data, the bytes of the renumbered faces.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import encode_connectivity, order_connectivity
    >>> coded = order_connectivity(np.array([[3, 1, 0], [1, 3, 2]]), 4)
    >>> coded.data == encode_connectivity(coded.order.F)
    True
    """

    order: Renumbering
    data: bytes


def _models() -> tuple[np.ndarray, np.ndarray]:
    return new_contexts(CONTEXTS, 127), new_weights(MIXERS)


def _close(F: np.ndarray, n: int) -> tuple[ClosedMesh, int]:
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
    tail, tip = F.reshape(-1)[h], np.roll(F, -1, axis=1).reshape(-1)[h]
    roots, loop = np.unique(component_labels(n, tail, tip)[tail], return_inverse=True)
    whole = np.concatenate([F, np.stack([tip, tail, n + loop.reshape(-1)], 1)]).astype(np.int64)
    degree = np.bincount(whole.reshape(-1), minlength=n + len(roots))
    if (degree < 3).any():
        raise MeshError("Expected at least three faces round an inner vertex, found two; the mesh has a collapsed part")
    return ClosedMesh(
        opposite=opposite_halfedges(whole).astype(np.int64), origin=whole.reshape(-1), degree=degree.astype(np.int64),
        is_dummy=(np.arange(len(degree)) >= n).astype(np.int64), node_of=np.full(whole.size, -1, np.int64),
        seen=np.zeros(len(degree), np.int64), done=np.zeros(len(whole), np.int64)), len(roots)


def order_connectivity(F0: np.ndarray, n0: int) -> OrderedConnectivity:
    """The order in which the receiver will see the base faces F0 (m, 3) over n0 vertices, and their bytes in that order.

    As `canonical_order` and `encode_connectivity`, in one pass. Raises MeshError as `canonical_order` does. Region growing
    steered by degrees: Touma and Gotsman 1998, Alliez and Desbrun 2001.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import decode_connectivity, order_connectivity
    >>> order, data = order_connectivity(np.array([[3, 1, 0], [1, 3, 2]]), 4)
    >>> len(data), (decode_connectivity(data) == order.F).all().tolist()
    (5, True)
    """
    F = np.ascontiguousarray(F0, dtype=np.int64)
    if not 0 < len(F) <= MAX_FACES:
        raise MeshError(f"Expected a base mesh of 1 to {MAX_FACES} faces, found {len(F)}; choose fewer base faces")
    closed, borders = _close(F, n0)
    numbering = Numbering(np.zeros_like(F), np.zeros(n0, np.int64), np.zeros(len(F), np.int64))
    coder = range_encoder(*_models(), capacity=64 + 40 * len(closed.done))
    found = grow(coder, new_degree_mixer(), new_surroundings(), new_boundary(len(F), borders), closed, numbering, 0)
    if found != n0:  # every manifold is covered: a bug, not an input
        raise RuntimeError(f"region growing covered {found} of {n0} vertices")
    order = Renumbering(numbering.vertex_of.astype(np.int32), (numbering.halfedge_of // 3).astype(np.int32),
                        numbering.faces.astype(np.int32))
    return OrderedConnectivity(order, write_varint(len(F)) + write_varint(borders) + finish_encoding(coder))


def canonical_order(F0: np.ndarray, n0: int) -> Renumbering:
    """The order in which the receiver will see the base faces F0 (m, 3) over n0 vertices; ours.

    Encoding and decoding the result's F gives exactly that F back: faces, corner rotation and numbering. Idempotent.
    Raises MeshError if F0 is not an oriented manifold, has isolated vertices, or more than MAX_FACES faces.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import canonical_order
    >>> order = canonical_order(np.array([[3, 1, 0], [1, 3, 2]]), 4)
    >>> order.vertices.tolist(), order.F.tolist()
    ([3, 1, 0, 2], [[0, 1, 2], [3, 1, 0]])
    """
    return order_connectivity(F0, n0).order


def encode_connectivity(F: np.ndarray) -> bytes:
    """Bytes of the faces F (m, 3) of a `canonical_order`. Raises MeshError in another order, or as that does.

    The receiver learns F and nothing else: faces, corner rotation and numbering. A regular mesh costs nearly nothing, an
    irregular one about two bits a face (Touma and Gotsman 1998, Alliez and Desbrun 2001).

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import encode_connectivity
    >>> len(encode_connectivity(np.array([[0, 1, 2], [3, 1, 0]])))
    5
    """
    F = np.asarray(F)
    order, data = order_connectivity(F, int(F.max()) + 1 if F.size else 0)
    if not np.array_equal(order.F, F):
        raise MeshError("Expected base faces in canonical order, found another; call canonical_order first")
    return data


def decode_connectivity(data: bytes) -> np.ndarray:
    """Faces (m, 3) int32 of `encode_connectivity`'s bytes. Raises StreamError if the bytes are not such a mesh.

    >>> import numpy as np
    >>> from npm_blender.core.bitstream import decode_connectivity, encode_connectivity
    >>> decode_connectivity(encode_connectivity(np.array([[0, 1, 2], [3, 1, 0]]))).tolist()
    [[0, 1, 2], [3, 1, 0]]
    """
    try:
        faces, at = read_varint(data, 0)
        borders, at = read_varint(data, at)
    except EOFError:
        raise StreamError("Expected the counts of the base mesh, found no data; the file is corrupted") from None
    if not (0 < faces <= MAX_FACES and borders <= faces):
        raise StreamError(f"Expected a base mesh of 1 to {MAX_FACES} faces, found {faces} faces and {borders} borders; "
                          "the file is corrupted")
    nothing = np.zeros(0, np.int64)
    closed = ClosedMesh(nothing, nothing, nothing, nothing, nothing, nothing, nothing)
    numbering = Numbering(np.zeros((faces, 3), np.int64), nothing, nothing)
    found = grow(range_decoder(*_models(), data[at:]), new_degree_mixer(), new_surroundings(),
                 new_boundary(faces, borders), closed, numbering, 0)
    try:
        if found < 3:
            raise MeshError("faces do not close up")
        opposite_halfedges(numbering.faces)
    except MeshError as e:
        raise StreamError("Expected a manifold base mesh, found faces that do not close up; the file is corrupted") from e
    return numbering.faces.astype(np.int32)
