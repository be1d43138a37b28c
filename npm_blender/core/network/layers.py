"""Layers of the network on the half-edge layout: face convolution, pooling, upsampling.

A face feature is stored in three corner slots, (3 m, C) in half-edge order (see `mesh.topology`): slot k belongs to corner k
and half-edge k. Whoever starts a face at another of its corners rotates its slots, and every layer here rotates its output
with them. So a layer can tell which of a face's three edges it looks at, which one sum over neighbours cannot (the kernel of
SubdivNet, Hu et al. 2022; the vertex displacement of the paper needs it, see docs/architecture.md).
All functions take a backend `B` (NumPy or torch) and arrays of that backend.
"""
from .backend import Array, Backend, Index, Layer


def circulant(B: Backend, w: Array) -> Array:
    """The matrix of a per-slot map that sees own, next and previous slot: (3 C, C') -> (3 C, 3 C').

    One product with whole faces, x.reshape(m, 3 C) @ circulant(w), then does what w does to every slot in turn.
    """
    c = len(w) // 3
    own, after, before = w[:c], w[c:2 * c], w[2 * c:]
    # column block k is the output of slot k; its row block s is the face's slot s, which k sees as own, next or previous
    return B.concat([B.concat([own, before, after], 1), B.concat([after, own, before], 1),
                     B.concat([before, after, own], 1)], 0)


def two_face_linear(B: Backend, x: Array, opposite: Index, layer: Layer) -> Array:
    """A linear map of a half-edge's face and the face across it, both with the shared edge's slot first.

    x (3 m, C) -> (3 m, C'); layer: own, other (3 C, C'), bias (C',). For half-edge h, with s(h) the three slots of its face
    from h on: y(h) = s(h) own + s(opposite(h)) other + bias. On the border the face meets itself.
    """
    m, width = len(x) // 3, layer["own"].shape[1]
    own, other = B.products(x.reshape(m, -1), circulant(B, layer["own"]), circulant(B, layer["other"]))
    return own.reshape(3 * m, width) + B.permute(other.reshape(3 * m, width), opposite) + layer["bias"]


def face_convolution(B: Backend, x: Array, opposite: Index, layer: Layer) -> Array:
    """Convolution over a face and its three neighbours, batch normalization, ReLU: (3 m, C) -> (3 m, C').

    Batch normalization uses running statistics as constants in training too, so that training and inference are the
    same function; weights that were folded for inference have no statistics.
    """
    y = two_face_linear(B, x, opposite, layer)
    if "gamma" in layer:
        B.observe(layer, y)
        y = (y - layer["mean"]) * (layer["gamma"] / B.sqrt(layer["var"] + 1e-5)) + layer["beta"]
    return B.relu(y)


def bilinear_upsample(B: Backend, x: Array, opposite: Index, layer: Layer) -> Array:
    """Features of the four children from a face and its neighbours: (3 m, C) -> (12 m, C').

    The child at corner k blends its parent with the neighbours across the two edges of that corner,
    (2 e_i + e_a + e_b) / 4, each with the shared corner's slot first; the centre child is the parent (paper:
    bilinear upsampling of SubdivNet). With it goes a linear map per slot: layer corner0, corner1, corner2, centre (3 C, C').
    """
    m, width = len(x) // 3, layer["centre"].shape[1]
    # the map comes before the blend: both are linear, and the map is one product with whole faces
    centre, corner = B.products(x.reshape(m, -1), circulant(B, layer["centre"]), corner_map(B, layer))
    centre, corner = centre.reshape(m, 1, 3, width), corner.reshape(3 * m, 3 * width)
    # the neighbour across edge k sees the shared corner at its next half-edge, the one across edge k - 1 at its own
    faces = corner.reshape(m, 3, -1)
    after = B.permute(B.roll_slots(faces, 1).reshape(3 * m, -1), opposite)
    across = B.permute(corner, opposite).reshape(m, 3, -1)
    before = B.roll_slots(across, 2).reshape(3 * m, -1)
    blend = (2 * corner + after + before) / 4
    return B.concat([blend.reshape(m, 3, 3, width), centre], 1).reshape(12 * m, width)


def corner_map(B: Backend, layer: Layer) -> Array:
    """Matrix (3 C, 9 C') from a face to the three slots of each of its three corner children."""
    return circulant(B, B.concat([layer["corner0"], layer["corner1"], layer["corner2"]], 1))


def average_pool(B: Backend, x: Array, layer: Layer) -> Array:
    """Features of a parent from its four children: (12 m, C) -> (3 m, C').

    Parent slot k is the mean over the children of their slots, seen from corner k, under a linear map per position:
    layer own, next, prev, centre (3 C, C') (paper: average pooling).
    """
    m = len(x) // 12
    corners = B.concat([layer["own"], layer["next"], layer["prev"]], 0)
    y = B.product(x.reshape(m, -1), B.concat([circulant(B, corners), circulant(B, layer["centre"])], 0))
    return (y / 4).reshape(3 * m, -1)
