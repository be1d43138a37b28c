import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.decimation import qem as module
from npm_blender.core.decimation.admissibility import ADMISSIBILITY_TESTS
from npm_blender.core.decimation.qem import FEWEST, MOST, decimate
from npm_blender.core.errors import Cancelled, MeshError
from npm_blender.core.evaluation.metrics import Original
from npm_blender.core.mesh.topology import opposite_halfedges, topology_of, vertex_fans
from npm_blender.core.mesh.triangle_mesh import TriMesh
from npm_blender.core.settings import AUTO
from tests.meshes.lod_meshes import gear, joined, sheet, sphere, torus, tube
from tests.meshes.shapes import bumpy

SHAPES = {"sphere": sphere, "torus": torus, "sheet": sheet, "tube": tube}


def same_topology(a, b):
    s, t = topology_of(a), topology_of(b)
    return (s.euler, s.components, s.border_loops) == (t.euler, t.components, t.border_loops)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("target", [400, 100, 60])
def test_reaches_the_target_and_keeps_the_topology(shape, target):
    mesh = SHAPES[shape]()
    out = decimate(mesh, target)
    assert len(out.F0) == target and out.message == ""
    assert same_topology(mesh.F, out.F0)
    assert (vertex_fans(out.F0, opposite_halfedges(out.F0), len(out.V0)) == 1).all()


@settings(max_examples=25, deadline=None)
@given(st.sampled_from(sorted(SHAPES)), st.integers(0, 99), st.floats(0, 0.02), st.integers(1, 300), st.integers(0, 3))
def test_topology_holds_for_noise_any_target_and_variant(shape, seed, noise, target, variant):
    mesh = SHAPES[shape](noise=noise, seed=seed)
    out = decimate(mesh, target, variant)
    assert same_topology(mesh.F, out.F0)
    assert np.isfinite(out.V0).all()
    assert len(out.F0) == target or out.message


@pytest.mark.parametrize("shape,least", [("sphere", 4), ("torus", 14), ("sheet", 1), ("tube", 6)])
def test_goes_to_the_smallest_mesh_of_the_topology_or_says_where_it_stopped(shape, least):
    out = decimate(SHAPES[shape](), 1, room=False)
    assert least <= len(out.F0) <= least + 6
    if len(out.F0) > 1:
        assert out.message.startswith(f"Reached {len(out.F0)} of 1 base faces: ")


def test_an_odd_target_of_a_closed_mesh_gives_one_face_less_and_says_so():
    out = decimate(sphere(), 101)
    assert len(out.F0) == 100
    assert out.message == "Reached 100 of 101 base faces: a closed mesh has an even number"


def test_an_odd_target_of_an_open_mesh_is_met():
    assert len(decimate(sheet(), 101).F0) == 101


def test_a_mesh_below_the_target_is_its_own_base():
    mesh = sphere(1)
    out = decimate(mesh, 400)
    assert np.array_equal(out.V0, mesh.V) and np.array_equal(np.sort(out.F0, 0), np.sort(mesh.F, 0))
    assert out.message == "Reached 32 of 400 base faces: the mesh has no more"


def test_a_flat_sheet_keeps_its_outline():
    out = decimate(sheet(flat=True), 8)
    assert out.mesh.face_areas().sum() == pytest.approx(TriMesh(out.V0, out.F0).face_areas().sum(), rel=1e-6)
    assert np.abs(out.V0[:, 2]).max() < 1e-9


def test_a_sphere_stays_close_to_the_sphere():
    out = decimate(sphere(4), 400)
    radius = np.linalg.norm(out.V0, axis=1)
    assert np.abs(radius - 0.5).max() < 0.01
    assert (TriMesh(out.V0, out.F0).face_normals() * out.V0[out.F0].mean(1)).sum(1).min() > 0


def test_every_component_survives():
    mesh = joined(sphere(2), torus(), sheet())
    out = decimate(mesh, 150)
    assert len(out.F0) == 150 and same_topology(mesh.F, out.F0)


def test_is_deterministic_and_variants_differ():
    mesh = torus(noise=0.005)
    one, two, three, four = (decimate(mesh, 200, v) for v in (0, 0, 7, 7))
    assert np.array_equal(one.V0, two.V0) and np.array_equal(one.F0, two.F0)
    assert np.array_equal(three.V0, four.V0) and np.array_equal(three.F0, four.F0)
    assert not np.array_equal(one.V0, three.V0)


def test_the_input_is_left_alone():
    mesh = sphere()
    V, F = mesh.V.copy(), mesh.F.copy()
    decimate(mesh, 100)
    assert np.array_equal(V, mesh.V) and np.array_equal(F, mesh.F)


def test_progress_rises_and_can_cancel():
    seen = []
    decimate(sphere(5), 100, progress=lambda f, m: seen.append(f))
    assert seen == sorted(seen) and seen[-1] == 1.0 and len(seen) >= 3

    def cancel(fraction, message):
        if fraction > 0.3:
            raise Cancelled("cancelled")

    with pytest.raises(Cancelled):
        decimate(sphere(5), 100, progress=cancel)


def test_a_vertex_of_many_faces_does_not_stall():
    n = 3000
    u = np.arange(n) * 2 * np.pi / n
    V = np.concatenate([[[0, 0, 0.3], [0, 0, -0.3]], np.stack([np.cos(u), np.sin(u), 0 * u], 1) / 2])
    k = np.arange(n)
    F = np.concatenate([np.stack([0 * k, 2 + k, 2 + (k + 1) % n], 1), np.stack([0 * k + 1, 2 + (k + 1) % n, 2 + k], 1)])
    out = decimate(TriMesh.from_arrays(V, F), 100)
    assert len(out.F0) == 100 and same_topology(F, out.F0)


def test_faces_without_area_do_not_stall():
    mesh = sheet(flat=True)
    V = mesh.V.copy()
    V[40:80] = V[40]
    out = decimate(TriMesh.from_arrays(V, mesh.F), 50)
    assert np.isfinite(out.V0).all() and same_topology(mesh.F, out.F0)


def test_non_manifold_edge_is_refused():
    F = [[0, 1, 2], [1, 0, 3], [0, 1, 4]]
    with pytest.raises(MeshError, match="oriented manifold"):
        decimate(TriMesh.from_arrays(np.random.default_rng(0).random((5, 3)), np.array(F)), 4)


def test_pinched_vertex_is_refused():
    F = [[0, 1, 2], [0, 3, 4]]
    with pytest.raises(MeshError, match="1 vertices where separate fans"):
        decimate(TriMesh.from_arrays(np.random.default_rng(0).random((5, 3)), np.array(F)), 4)


def test_unused_vertices_are_not_in_the_base():
    mesh = sphere()
    out = decimate(TriMesh.from_arrays(np.concatenate([mesh.V, [[9, 9, 9]]]), mesh.F), 100)
    assert len(out.V0) == 52 and np.abs(out.V0).max() < 1


def test_a_chosen_base_has_more_faces_where_there_is_more_shape():
    plain, bumps = decimate(sphere(5), AUTO), decimate(bumpy(5), AUTO)
    assert FEWEST <= len(plain.F0) < 0.7 * len(bumps.F0) and len(bumps.F0) <= MOST
    assert plain.message == bumps.message == ""


def test_a_chosen_base_has_room_for_every_part():
    assert len(decimate(joined(*[sphere(2)] * 40), AUTO).F0) >= 160


def test_a_chosen_base_of_a_flat_sheet_is_the_smallest():
    assert len(decimate(sheet(flat=True), AUTO).F0) == FEWEST


def test_where_few_collapses_pass_the_tests_a_milder_one_comes_before_a_dear_one(monkeypatch):
    mesh, error = gear(), {}
    for last_resort in (False, True):
        if last_resort:
            first, *milder = ADMISSIBILITY_TESTS
            monkeypatch.setattr(module, "ADMISSIBILITY_TESTS", [first, *(test._replace(price=1e30) for test in milder)])
        base = decimate(mesh, 200)
        error[last_resort] = Original(mesh, 5000).evaluate(TriMesh(base.V0, base.F0)).d_pm
    assert error[False] < 0.5 * error[True]


def test_small_parts_that_need_all_the_faces_do_not_starve_a_large_one():
    dust = [TriMesh(0.05 * sphere(1).V, sphere(1).F)] * 50
    out = decimate(joined(sphere(4), *dust), 100)
    large = out.vertices[out.F0[:, 0]] < len(sphere(4).V)
    assert large.sum() >= 40 and (~large).sum() >= 200
    assert out.message.startswith(f"Reached {len(out.F0)} of 100 base faces: the 51 separate parts of the mesh need")
