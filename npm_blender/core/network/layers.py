"""Operators of the network on the half-edge layout: face convolution, pooling, upsampling, edge frames.

A face feature is stored in three corner slots, (3 m, C) in half-edge order (see topology): slot k belongs to corner k
and half-edge k. Turning the corners of a face turns its slots, so every operator here is equivariant to the corner
order, and a layer can tell which of a face's three edges it looks at - which one sum over neighbours cannot
(SubdivNet's kernel; the vertex displacement of the paper needs it, see docs/architecture.md).
All functions take a backend `B` (NumPy or torch) and arrays of that backend.
"""
from dataclasses import dataclass

import numpy as np

from ..mesh.subdivision import Level


@dataclass(frozen=True)
class MeshIndex:
    """A level's connectivity as index arrays of a backend.

    F (3 m,) corner vertices, which half-edges start at; opposite (3 m,); end (3 m,) where they end; edge_a, edge_b (e,)
    ends of each edge; left, right (e,) the half-edges of each edge (equal on the border); inner (3 m, 1) float: 0 on the
    border, else 1; share (n, 1) float: 1 / number of corners at a vertex; edge_of (3 m,): edge of each half-edge;
    side (3 m, 1) float: 1 if it is the edge's left half-edge, else -1.
    """

    m: int
    n: int
    F: object
    opposite: object
    end: object
    edge_a: object
    edge_b: object
    left: object
    right: object
    inner: object
    share: object
    edge_of: object
    side: object

    @staticmethod
    def of(B, level: Level) -> "MeshIndex":
        """The index arrays of one level."""
        m = len(level.F)
        end = level.F[:, [1, 2, 0]].reshape(-1)
        halfedge = np.arange(3 * m)
        inner = (level.opposite != halfedge).astype(np.float32)[:, None]
        share = 1 / np.maximum(np.bincount(level.F.reshape(-1), minlength=level.n), 1)[:, None]
        side = np.where(level.edge_halfedge[level.edge_of, 0] == halfedge, 1, -1).astype(np.float32)[:, None]
        return MeshIndex(m, level.n, B.index(level.F.reshape(-1)), B.index(level.opposite), B.index(end),
                         B.index(level.edges[:, 0]), B.index(level.edges[:, 1]), B.index(level.edge_halfedge[:, 0]),
                         B.index(level.edge_halfedge[:, 1]), B.array(inner), B.array(share), B.index(level.edge_of),
                         B.array(side))


def circulant(B, w):
    """The matrix of a per-slot map that sees own, next and previous slot: (3 C, C') -> (3 C, 3 C').

    One product with whole faces, x.reshape(m, 3 C) @ circulant(w), then does what w does to every slot in turn.
    """
    c = len(w) // 3
    own, after, before = w[:c], w[c:2 * c], w[2 * c:]
    # column block k is the output of slot k; its row block s is the face's slot s, which k sees as own, next or previous
    return B.concat([B.concat([own, before, after], 1), B.concat([after, own, before], 1),
                     B.concat([before, after, own], 1)], 0)


def two_face_linear(B, x, opposite, layer):
    """A linear map of a half-edge's face and the face across it, both turned so that the shared edge comes first.

    x (3 m, C) -> (3 m, C'); layer: own, other (3 C, C'), bias (C',). On the border the face meets itself.
    """
    m, width = len(x) // 3, layer["own"].shape[1]
    own, other = B.products(x.reshape(m, -1), circulant(B, layer["own"]), circulant(B, layer["other"]))
    return own.reshape(3 * m, width) + B.permute(other.reshape(3 * m, width), opposite) + layer["bias"]


def face_convolution(B, x, opposite, layer):
    """Convolution over a face and its three neighbours, batch normalization, ReLU: (3 m, C) -> (3 m, C').

    Batch normalization uses running statistics as constants in training too, so that training and inference are the
    same function; weights that were folded for inference have no statistics.
    """
    y = two_face_linear(B, x, opposite, layer)
    if "gamma" in layer:
        B.observe(layer, y)
        y = (y - layer["mean"]) * (layer["gamma"] / B.sqrt(layer["var"] + 1e-5)) + layer["beta"]
    return B.relu(y)


def bilinear_upsample(B, x, opposite, layer):
    """Features of the four children from a face and its neighbours: (3 m, C) -> (12 m, C').

    The child at corner k blends its parent with the neighbours across the two edges of that corner,
    (2 e_i + e_a + e_b) / 4, each turned so that the shared corner comes first; the centre child is the parent (paper:
    bilinear upsampling of SubdivNet). With it goes a linear map per slot: layer corner0, corner1, corner2, centre (3 C, C').
    """
    m, width = len(x) // 3, layer["centre"].shape[1]
    # the map comes before the blend: both are linear, and the map is one product with whole faces
    centre, corner = B.products(x.reshape(m, -1), circulant(B, layer["centre"]), corner_map(B, layer))
    centre, corner = centre.reshape(m, 1, 3, width), corner.reshape(3 * m, 3 * width)
    # the neighbour across edge k sees the shared corner at its next half-edge, the one across edge k - 1 at its own
    faces = corner.reshape(m, 3, -1)
    after = B.permute(B.turn(faces, 1).reshape(3 * m, -1), opposite)
    across = B.permute(corner, opposite).reshape(m, 3, -1)
    before = B.turn(across, 2).reshape(3 * m, -1)
    blend = (2 * corner + after + before) / 4
    return B.concat([blend.reshape(m, 3, 3, width), centre], 1).reshape(12 * m, width)


def corner_map(B, layer):
    """Matrix (3 C, 9 C') from a face to the three slots of each of its three corner children."""
    return circulant(B, B.concat([layer["corner0"], layer["corner1"], layer["corner2"]], 1))


def average_pool(B, x, layer):
    """Features of a parent from its four children: (12 m, C) -> (3 m, C').

    Parent slot k is the mean over the children of their slots, seen from corner k, under a linear map per position:
    layer own, next, prev, centre (3 C, C') (paper: average pooling).
    """
    m = len(x) // 12
    corners = B.concat([layer["own"], layer["next"], layer["prev"]], 0)
    y = B.product(x.reshape(m, -1), B.concat([circulant(B, corners), circulant(B, layer["centre"])], 0))
    return (y / 4).reshape(3 * m, -1)


def edge_frames(B, V, mesh: MeshIndex):
    """Local frame of every edge: x along it, z the mean of its two face normals, y = z x x (rows), and its length.

    V (n, 3) -> x, y, z (e, 3), length (e, 1). The half-edge on the other side sees x and y negated, and the same z.
    """
    normal, _ = face_normals(B, V, mesh)
    ends = B.take(V, mesh.edge_b) - B.take(V, mesh.edge_a)
    length = norm(B, ends)
    x = ends / length
    face = mesh.left // 3, mesh.right // 3
    z = B.take(normal, face[0]) + B.take(normal, face[1])
    z = z - x * B.dot(x, z)[:, None]
    z = z / norm(B, z)
    return x, B.cross(z, x), z, length


def corner_frames(B, V, mesh: MeshIndex):
    """Local frame of every corner: x along its half-edge, z the face normal, y = z x x (rows), and the edge's length.

    V (n, 3) -> x, y, z (3 m, 3), length (3 m, 1).
    """
    normal, _ = face_normals(B, V, mesh)
    z = B.concat([normal[:, None]] * 3, 1).reshape(3 * mesh.m, 3)
    edge = B.take(V, mesh.end) - B.take(V, mesh.F)
    length = norm(B, edge)
    x = edge / length
    return x, B.cross(z, x), z, length


def face_normals(B, V, mesh: MeshIndex):
    """Unit normals (m, 3) and twice the areas (m, 1) of the faces of V (n, 3)."""
    corners = B.take(V, mesh.F).reshape(mesh.m, 3, 3)
    normal = B.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = norm(B, normal, 1e-20)
    return normal / size, size


def norm(B, x, floor=1e-12):
    """Euclidean norm of rows (m, c) -> (m, 1), bounded below so that gradients stay finite."""
    return B.sqrt(B.clamp(B.dot(x, x)[:, None], floor))
