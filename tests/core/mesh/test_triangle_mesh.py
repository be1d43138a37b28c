import numpy as np
import pytest

from npm_blender.core.errors import MeshError
from npm_blender.core.mesh.triangle_mesh import TriMesh, UnitFrame, compact
from tests.meshes.shapes import icosphere

V, F = np.eye(3), np.array([[0, 1, 2]])


@pytest.mark.parametrize(("V", "F", "message"), [
    (V[:0], F, "a mesh with vertices"), (V, F[:0], "a mesh with faces"), (V[:, :2], F, r"vertices \(n, 3\)"),
    (V.astype(str), F, "real numbers"), (V, np.array([[0, 1, 2, 0]]), "triangulate"), (V, F.astype(float), "integers"),
    (np.where(V > 0, np.nan, V), F, "3 vertices with NaN"), (V, F + 1, r"0\.\.2, found 1\.\.3"), (V, F - 1, r"found -1\.\.1")])
def test_arrays_that_are_no_mesh_are_refused_in_words(V, F, message):
    with pytest.raises(MeshError, match=message):
        TriMesh.from_arrays(V, F)


def test_arrays_are_converted_and_kept():
    mesh = TriMesh.from_arrays(V.astype(np.float32).tolist(), F.astype(np.uint8))
    assert mesh.V.dtype == np.float64 and mesh.F.dtype == np.int32
    assert np.array_equal(mesh.V, V) and np.array_equal(mesh.F, F)


def test_normals_and_areas_of_a_sphere():
    mesh = icosphere(3)
    normals, centres = mesh.face_normals(), mesh.V[mesh.F].mean(1)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1) and (np.einsum("ij,ij->i", normals, centres) > 0).all()
    assert abs(mesh.face_areas().sum() / (4 * np.pi) - 1) < 0.02


def test_a_face_without_area_has_the_normal_zero():
    assert not TriMesh(V, np.array([[0, 1, 1]], np.int32)).face_normals().any()


def test_the_unit_frame_puts_the_longest_side_between_minus_and_plus_one_half():
    P = np.random.default_rng(0).normal(size=(50, 3)) * [3, 1, 2] + 7
    frame = UnitFrame.of(P)
    unit = frame.to_unit(P)
    assert np.isclose(np.ptp(unit, axis=0).max(), 1) and np.allclose(unit.max(0), -unit.min(0))
    assert np.allclose(frame.to_object(unit), P)
    with pytest.raises(MeshError, match="all vertices in one point"):
        UnitFrame.of(np.ones((4, 3)))


def test_compact_drops_what_no_face_uses_and_keeps_the_order():
    P = np.arange(15.0).reshape(5, 3)
    kept, F = compact(P, np.array([[4, 1, 2], [2, 1, 4]]))
    assert np.array_equal(kept, P[[1, 2, 4]]) and np.array_equal(kept[F], P[[[4, 1, 2], [2, 1, 4]]])
    assert compact(kept, F)[0] is kept
