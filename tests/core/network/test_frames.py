import numpy as np
import pytest

from npm_blender.core.mesh.subdivision import Level
from npm_blender.core.network.frames import corner_frames, edge_frames, face_normals
from npm_blender.core.network.mesh_index import MeshIndex
from npm_blender.core.network.numpy_backend import NUMPY
from tests.core.network.samples import SHAPES


@pytest.mark.parametrize("name", SHAPES)
def test_edge_frames_are_orthonormal(name):
    mesh = SHAPES[name]
    index = MeshIndex.of(NUMPY, Level.of(mesh.F, len(mesh.V)))
    x, y, z, length = edge_frames(NUMPY, mesh.V.astype(np.float32), index)
    frame = np.stack([x, y, z], 1)
    assert np.allclose(frame @ frame.transpose(0, 2, 1), np.eye(3), atol=1e-5)
    assert (np.linalg.det(frame) > 0.99).all() and (length > 0).all()


@pytest.mark.parametrize("name", SHAPES)
def test_corner_frames_are_orthonormal_and_stand_on_their_face(name):
    mesh = SHAPES[name]
    index = MeshIndex.of(NUMPY, Level.of(mesh.F, len(mesh.V)))
    x, y, z, length = corner_frames(NUMPY, mesh.V.astype(np.float32), index)
    frame = np.stack([x, y, z], 1)
    assert np.allclose(frame @ frame.transpose(0, 2, 1), np.eye(3), atol=1e-5)
    assert np.allclose(z, np.repeat(mesh.face_normals(), 3, 0), atol=1e-5)
    ends = mesh.V[np.roll(mesh.F, -1, 1)] - mesh.V[mesh.F]
    assert np.allclose(x * length, ends.reshape(-1, 3), atol=1e-5)


@pytest.mark.parametrize("name", SHAPES)
def test_normals_and_areas_are_those_of_the_mesh(name):
    mesh = SHAPES[name]
    normal, twice = face_normals(NUMPY, mesh.V.astype(np.float32), MeshIndex.of(NUMPY, Level.of(mesh.F, len(mesh.V))))
    assert np.allclose(normal, mesh.face_normals(), atol=1e-5)
    assert np.allclose(twice[:, 0] / 2, mesh.face_areas(), atol=1e-5)
