"""Local frames of edges and corners, and face normals, of a backend's arrays."""
from .backend import Array, Backend
from .mesh_index import MeshIndex


def edge_frames(B: Backend, V: Array, mesh: MeshIndex) -> tuple[Array, Array, Array, Array]:
    """Local frame of every edge: V (n, 3) -> x, y, z (e, 3), its axes as rows, and length (e, 1), in units of V.

    For the edge a-b between faces of unit normals n1 and n2 (the same face twice on the border), s = n1 + n2:
    x = (b - a) / |b - a|, z = (s - (s . x) x) / |s - (s . x) x|, y = z x x. The half-edge on the other side sees x and y
    negated, and the same z. Ours.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import Level
    >>> from npm_blender.core.network import NUMPY, MeshIndex, edge_frames
    >>> mesh = MeshIndex.of(NUMPY, Level.of(np.array([[0, 1, 2]]), 3))  # its edges: 0-1, 0-2, 1-2
    >>> x, y, z, length = edge_frames(NUMPY, NUMPY.array([[0, 0, 0], [2, 0, 0], [0, 1, 0]]), mesh)
    >>> x[:2].tolist(), z[0].tolist(), length[:2, 0].tolist()
    ([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [0.0, 0.0, 1.0], [2.0, 1.0])
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


def corner_frames(B: Backend, V: Array, mesh: MeshIndex) -> tuple[Array, Array, Array, Array]:
    """Local frame of every corner: x along its half-edge, z the face normal, y = z x x (rows), and the edge's length.

    V (n, 3) -> x, y, z (3 m, 3), length (3 m, 1).
    """
    normal, _ = face_normals(B, V, mesh)
    z = B.concat([normal[:, None]] * 3, 1).reshape(3 * mesh.m, 3)
    edge = B.take(V, mesh.end) - B.take(V, mesh.F)
    length = norm(B, edge)
    x = edge / length
    return x, B.cross(z, x), z, length


def face_normals(B: Backend, V: Array, mesh: MeshIndex) -> tuple[Array, Array]:
    """Unit normals (m, 3) and twice the areas (m, 1) of the faces of V (n, 3), in squared units of V.

    For the face (a, b, c) with p = (b - a) x (c - a): p / |p| and |p|; |p| is at least 1e-10, so that a face without area gets
    a normal near zero and finite gradients.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import Level
    >>> from npm_blender.core.network import NUMPY, MeshIndex, face_normals
    >>> mesh = MeshIndex.of(NUMPY, Level.of(np.array([[0, 1, 2]]), 3))
    >>> normal, twice_area = face_normals(NUMPY, NUMPY.array([[0, 0, 0], [2, 0, 0], [0, 1, 0]]), mesh)
    >>> normal.tolist(), twice_area.tolist()
    ([[0.0, 0.0, 1.0]], [[2.0]])
    """
    corners = B.take(V, mesh.F).reshape(mesh.m, 3, 3)
    normal = B.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = norm(B, normal, 1e-20)
    return normal / size, size


def norm(B: Backend, x: Array, floor: float = 1e-12) -> Array:
    """Euclidean norm of rows (m, c) -> (m, 1); its square is bounded below by `floor`, so that gradients stay finite."""
    return B.sqrt(B.clamp(B.dot(x, x)[:, None], floor))
