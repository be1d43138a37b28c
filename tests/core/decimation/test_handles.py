"""Bases of meshes with many handles: a number that can be reached is obeyed, else there are enough faces to show them."""
import numpy as np
import pytest

from npm_blender.core.codec.compression import compress
from npm_blender.core.decimation import qem as module
from npm_blender.core.decimation.face_bounds import HANDLE, FaceAdvice, face_advice
from npm_blender.core.decimation.qem import DEAR, MOST, decimate
from npm_blender.core.evaluation.metrics import Original
from npm_blender.core.levels.lod_sequence import build_levels
from npm_blender.core.mesh.subdivision import hierarchy
from npm_blender.core.mesh.topology import topology_of
from npm_blender.core.mesh.triangle_mesh import TriMesh
from npm_blender.core.settings import AUTO, CompressSettings, LodSettings
from tests.meshes.lod_meshes import grating, joined, sheet, sphere, torus, tube

LEAST = 502  # of a plate with 7 x 7 holes


def turned(lod):
    """Share of the faces of each level that oppose the input's normals at their corners."""
    finer = hierarchy(lod.F0, len(lod.V0), lod.level_count)[1:]
    return np.array([((TriMesh(lod.V, x.F).face_normals() * lod.N[x.F].sum(1)).sum(1) < 0).mean() for x in finer])


def error(mesh, lod):
    finest = hierarchy(lod.F0, len(lod.V0), lod.level_count)[-1]
    return Original(mesh, 20_000).evaluate(TriMesh(lod.V, finest.F)).d_pm


@pytest.mark.parametrize("mesh, faces", [(torus(), 24), (grating(4), 16 * 24), (sphere(), 0), (sheet(), 0), (tube(), 0),
                                         (grating(4, open_sheet=True), 0), (joined(torus(), torus(), sphere()), 56)])
def test_handles_ask_for_faces_and_borders_do_not(mesh, faces):
    least = decimate(mesh, 4, room=False).F0
    ample, none = (face_advice(least, 4, most).faces for most in (10**6, 0))
    assert ample == (faces or none)
    assert face_advice(least, len(least), len(mesh.F)) == FaceAdvice()


@pytest.mark.slow
def test_a_base_below_what_handles_need_gets_faces_that_show_them():
    mesh = grating(7)
    base = decimate(mesh, 400)
    assert len(base.F0) == 49 * HANDLE and topology_of(base.F0).genus == 49
    assert base.message == (f"Reached 1176 of 400 base faces: the handles of the mesh (holes through it: 49) need at least "
                            f"{LEAST} base faces and got 1,176 to be recognizable; ask for {LEAST} or more, or close holes")
    shown, pressed = build_levels(base, 3), build_levels(decimate(mesh, 400, room=False), 3)
    assert len(pressed.F0) == LEAST
    assert (turned(shown) <= 0.001).all() and turned(pressed)[-1] > 0.001
    assert error(mesh, shown) < 0.1 * error(mesh, pressed)


@pytest.mark.slow
@pytest.mark.parametrize("size", [9, 12])
def test_larger_gratings_have_no_turned_faces_either(size):
    lod = build_levels(decimate(grating(size), 400), 3)
    assert (turned(lod) <= 0.001).all()


@pytest.mark.parametrize("target", [LEAST + 2, 700, 1176, 2000])
def test_a_number_that_can_be_reached_is_obeyed_however_many_handles(target):
    base = decimate(grating(7), target)
    assert len(base.F0) == target and base.message == ""


@pytest.mark.parametrize("variant", [0, 3])
def test_every_run_gives_the_same_base(variant):
    one, two = (decimate(grating(5), 100, variant) for _ in range(2))
    assert np.array_equal(one.V0, two.V0) and np.array_equal(one.F0, two.F0)


def test_a_base_has_at_most_half_the_faces_of_the_mesh_for_its_handles():
    mesh = grating(7, levels=0)
    base = decimate(mesh, 400)
    assert len(mesh.F) == 1216 and len(base.F0) == 608
    assert "got 608 to be recognizable" in base.message


def test_a_mesh_without_room_for_more_is_pressed_and_says_so():
    mesh = decimate(grating(7), 700)
    base = decimate(TriMesh(mesh.V0, mesh.F0), 400)
    assert 400 < len(base.F0) < 600
    assert base.message == (f"Reached {len(base.F0)} of 400 base faces: the handles of the mesh (holes through it: 49) need at "
                            f"least {len(base.F0)} base faces; ask for {len(base.F0)} or more, or close holes")


def test_holes_in_an_open_sheet_need_no_more_than_their_borders_do():
    mesh = grating(9, open_sheet=True)
    base, least = decimate(mesh, 400), decimate(mesh, 400, room=False)
    assert len(base.F0) == len(least.F0) and base.message == least.message
    assert "handles and borders of the mesh need at least" in base.message
    assert (turned(build_levels(base, 3)) <= 0.001).all()


def test_parts_and_handles_both_get_their_faces():
    dust = [TriMesh(0.05 * sphere(1).V, sphere(1).F)] * 30
    mesh = joined(grating(7), *dust)
    base = decimate(mesh, 100)
    large = base.vertices[base.F0[:, 0]] < len(grating(7).V)
    assert len(base.F0) == 49 * HANDLE + 30 * 4 and large.sum() > 2 * LEAST and (~large).sum() >= 120
    assert "(holes through it: 49)" in base.message


def test_a_chosen_base_has_faces_for_its_handles(monkeypatch):
    mesh = grating(7)
    monkeypatch.setattr(module, "DEAR", 1e3 * DEAR)
    base = decimate(mesh, AUTO)
    assert len(base.F0) == 49 * HANDLE and base.message == ""
    monkeypatch.setattr("npm_blender.core.decimation.face_bounds.HANDLE", 0)
    assert len(decimate(mesh, AUTO).F0) < 49 * 20


def test_a_chosen_base_of_very_many_handles_is_larger_than_others():
    base = decimate(grating(10), AUTO)
    assert len(base.F0) == 100 * HANDLE > MOST and base.message == ""


@pytest.mark.slow
def test_a_budget_that_does_not_pay_for_the_room_gets_the_least_base():
    mesh = grating(7)
    settings = [CompressSettings(lod=LodSettings(base_faces=400, levels=1), budget=b) for b in (5000, 1500)]
    ample, tight = (compress(mesh, s) for s in settings)
    assert ample.report.base_faces == 49 * HANDLE and abs(tight.report.base_faces - LEAST) <= 20
    assert len(tight.data) <= 1500 and len(ample.data) <= 5000
