import numpy as np

from npm_blender.core.geometry.normals import normals_of, vertex_normals
from npm_blender.core.mesh.triangle_mesh import TriMesh
from tests.meshes.lod_meshes import sphere, torus


def test_vertex_normals_point_outward_and_are_weighted_by_area():
    mesh = sphere(3, noise=0.01)
    N = vertex_normals(mesh)
    assert ((N * mesh.V).sum(1) > 0.4).all()
    weighted = mesh.face_normals() * mesh.face_areas()[:, None]
    for v in (0, 17, len(mesh.V) - 1):
        total = weighted[(mesh.F == v).any(1)].sum(0)
        assert np.allclose(N[v], total / np.linalg.norm(total))


def test_normals_of_some_faces_are_those_of_the_mesh():
    mesh = torus(noise=0.01)
    faces = np.array([5, 0, 5, len(mesh.F) - 1], np.int32)
    assert np.allclose(normals_of(mesh, faces), mesh.face_normals()[faces])


def test_what_has_no_direction_is_zero():
    V = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], float)
    flat_and_back = TriMesh(V, np.array([[0, 1, 2], [0, 1, 3], [0, 3, 1]], np.int32))
    assert not vertex_normals(flat_and_back).any()
    assert not normals_of(flat_and_back, np.array([0])).any()
