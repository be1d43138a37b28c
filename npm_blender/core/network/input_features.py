"""The 13 geometry features of a face (paper section 3.2), in a form that no motion and no scaling changes.

The paper gives every face its area, three interior angles, three products of face and vertex normals, its centre and
its normal. Centre and normal in world axes make the network depend on the pose (the paper rotates its training data
in 90 degree steps against that); here the same six numbers are seen from the face itself: how far each neighbour's
centre stands off the face's plane, and the angle to each neighbour's normal. In slots: 1 + 4 x 3 = 13 numbers, plus a
flag per border edge.
"""
from .backend import Array, Backend
from .frames import face_normals, norm
from .mesh_index import MeshIndex

CHANNELS = 6


def geometry_features(B: Backend, V: Array, mesh: MeshIndex) -> Array:
    """Geometry features of every face of V (n, 3), in slots: (3 m, 6) with the columns

    area: log of face area over the mean of the level, quartered; angle at the corner minus pi / 3 (radians);
    1 - face normal . vertex normal; offset of the neighbour's centre from the face plane over edge length plus distance
    of centres; 1 - face normal . neighbour's normal; 1 on a border edge. From the paper's thirteen (section 3.2); the form is
    ours.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import Level
    >>> from npm_blender.core.network import NUMPY, MeshIndex, geometry_features
    >>> mesh = MeshIndex.of(NUMPY, Level.of(np.array([[0, 1, 2], [0, 2, 3]]), 4))  # a square cut along 0-2
    >>> g = geometry_features(NUMPY, NUMPY.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), mesh)
    >>> np.rad2deg(g[:, 1] + np.pi / 3).round().tolist()
    [45.0, 90.0, 45.0, 45.0, 45.0, 90.0]
    """
    m = mesh.m
    normal, twice = face_normals(B, V, mesh)
    start, end = B.take(V, mesh.F), B.take(V, mesh.end)
    edge = (end - start).reshape(m, 3, 3)
    back = B.roll_slots(edge, 2)
    dot = -B.dot(edge, back)
    area = B.log(B.clamp(twice, 1e-10) / B.clamp(twice.mean(), 1e-10)) * 0.25
    # the floor keeps the gradient of degenerate corners finite
    angle = B.arctan2(twice + 0 * dot + 1e-9, dot) - 1.0471975512
    weighted = normal * twice
    at_vertex = B.scatter_sum(repeat3(B, weighted), mesh.F, mesh.n)
    at_vertex = at_vertex / norm(B, at_vertex, 1e-20)
    own = repeat3(B, normal)
    lean = 1 - B.dot(B.take(at_vertex, mesh.F), own)[:, None]
    corner = start.reshape(m, 3, 3)
    centre = repeat3(B, (corner[:, 0] + corner[:, 1] + corner[:, 2]) / 3)
    away = B.permute(centre, mesh.opposite) - centre
    offset = B.dot(away, own)[:, None] / (norm(B, edge.reshape(3 * m, 3)) + norm(B, away))
    fold = 1 - B.dot(B.permute(own, mesh.opposite), own)[:, None]
    return B.concat([repeat3(B, area), angle.reshape(3 * m, 1), lean, offset, fold, 1 - mesh.inner], 1)


def repeat3(B: Backend, x: Array) -> Array:
    """A value per face, once for each of its corners: (m, c) -> (3 m, c)."""
    return B.concat([x[:, None]] * 3, 1).reshape(3 * len(x), x.shape[1])
