import numpy as np
import pytest

from npm_blender.core.errors import MeshError
from npm_blender.core.geometry.closest_point import ClosestPoints
from npm_blender.core.geometry.sampling import sample
from npm_blender.core.mesh.triangle_mesh import TriMesh
from tests.meshes.lod_meshes import torus


def test_samples_are_uniform_by_area_and_lie_on_their_face():
    mesh = TriMesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [4, 0, 0], [7, 0, 0], [4, 3, 0.0]]),
                   np.array([[0, 1, 2], [1, 1, 2], [3, 4, 5], [2, 2, 2]], np.int32))
    points, face = sample(mesh, 50_000, 1)
    assert np.bincount(face, minlength=4) == pytest.approx([5000, 0, 45_000, 0], abs=1)
    inside = points[face == 2] - [4, 0, 0]
    np.testing.assert_allclose(inside.mean(0), [1, 1, 0], atol=0.02)  # the centroid
    assert (inside[:, 0] + inside[:, 1] <= 3 + 1e-12).all() and (inside >= 0).all()
    # uniform inside: a quarter of the points lies in each of the four half-size triangles
    assert (inside[:, 0] >= 1.5).mean() == pytest.approx(0.25, abs=0.01)
    np.testing.assert_allclose(ClosestPoints(mesh).closest(points)[0], 0, atol=1e-12)


def test_the_same_seed_gives_the_same_samples():
    assert (sample(torus(), 1000, 1)[0] == sample(torus(), 1000, 1)[0]).all()
    assert (sample(torus(), 1000, 1)[0] != sample(torus(), 1000, 2)[0]).any()


def test_a_mesh_without_area_cannot_be_sampled():
    with pytest.raises(MeshError, match="zero area"):
        sample(TriMesh(np.eye(3), np.array([[0, 0, 1]], np.int32)), 10, 0)
