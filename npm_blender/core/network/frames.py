"""Local frames of edges and corners, and face normals, of a backend's arrays."""
from .mesh_index import MeshIndex


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
