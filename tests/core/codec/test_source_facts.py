"""The frame of a stream: its low corner is the mesh's, so that planes along the axes lie on the lattice."""
import numpy as np
import pytest

from npm_blender.core.codec.source_facts import in_frame, lattice_frame
from npm_blender.core.errors import MeshError
from npm_blender.core.mesh import TriMesh
from tests.meshes.shapes import bumpy


def test_the_box_lies_in_the_unit_cube_and_touches_its_corner():
    mesh = bumpy(2)
    far = TriMesh(mesh.V * 3 + [1e5, 0, -7], mesh.F)
    unit = in_frame(far, lattice_frame(far.V))
    assert (unit.V.min(0) == 0).all() and np.ptp(unit.V, axis=0).max() == pytest.approx(1, abs=1e-6)
    assert len(unit.F) == len(mesh.F) and unit.face_areas().sum() * 9 == pytest.approx(
        9 * far.face_areas().sum() / lattice_frame(far.V).size ** 2)


def test_the_unit_is_what_a_file_keeps():
    frame = lattice_frame(np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.05, 0]]))
    assert frame.size == np.float32(0.1) and frame.centre.tolist() == [0, 0, 0]


def test_a_point_has_no_frame():
    with pytest.raises(MeshError):
        lattice_frame(np.ones((3, 3)))
