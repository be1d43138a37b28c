"""A number of faces is a wish: no part of a mesh is given up to reach an odd one."""
import pytest

from npm_blender.core.decimation import decimate
from npm_blender.core.mesh import TriMesh, UnitFrame
from tests.meshes.shapes import grid
from tests.meshes.thin_shapes import statue

STATUE = statue()
UNIT = TriMesh(UnitFrame.of(STATUE.V).to_unit(STATUE.V), STATUE.F)


@pytest.mark.parametrize("faces", [1281, 401, 400, 399, 101, 21])
def test_a_square_of_two_triangles_keeps_both(faces):
    base = decimate(UNIT, faces)
    assert len(base.F0) == faces - faces % 2
    assert TriMesh(base.V0, base.F0).face_areas().sum() == pytest.approx(UNIT.face_areas().sum(), rel=0.01)
    assert bool(base.message) == bool(faces % 2)


@pytest.mark.parametrize("faces", [61, 60, 59])
def test_a_sheet_whose_border_is_like_the_rest_of_it_gets_as_many_as_asked_for(faces):
    assert len(decimate(grid(16), faces).F0) == faces
