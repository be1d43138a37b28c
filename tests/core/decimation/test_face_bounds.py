import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.decimation.base_message import base_message
from npm_blender.core.decimation.face_bounds import Cause, FaceAdvice, face_advice, least_faces
from npm_blender.core.decimation.qem import decimate
from npm_blender.core.mesh.components import component_labels
from npm_blender.core.mesh.topology import topology_of
from npm_blender.core.mesh.triangle_mesh import TriMesh, UnitFrame
from tests.meshes.dirty_meshes import box, joined, mesh, moved, plane, sphere, tetrahedron, tube, wave, without
from tests.meshes.shapes import torus

PARTS = {"tetrahedron": tetrahedron, "sphere": sphere, "triangle": lambda: mesh(np.eye(3), [[0, 1, 2]]), "cube": box,
         "sheet": wave, "card": plane, "tube": tube, "torus": lambda: mesh(torus(12, 8).V, torus(12, 8).F)}


@pytest.mark.parametrize("m, parts, least", [
    (sphere(), 1, 4), (wave(), 1, 1), (tube(), 1, 6), (torus(), 1, 14), (without(sphere(), [0, 300]), 1, 6),
    (without(sphere(), [0, 100, 300]), 1, 11), (joined(sphere(), wave(), tube()), 3, 11),
    (joined(*[tetrahedron(at=(3 * k, 0, 0)) for k in range(50)]), 50, 200), (mesh(np.eye(3), [[0, 1, 2]]), 1, 1),
])
def test_least_faces(m, parts, least):
    assert least_faces(m.F) == (parts, least)


def components(m):
    """Faces of each component, as arrays of indices."""
    opposite = {}
    for f, corners in enumerate(m.F.tolist()):
        for k in range(3):
            opposite[(corners[k], corners[k - 2])] = f
    pairs = [(f, opposite[(b, a)]) for (a, b), f in opposite.items() if (b, a) in opposite]
    part = component_labels(len(m.F), *(np.array(pairs).T if pairs else np.zeros((2, 0), int)))
    return [np.flatnonzero(part == p) for p in np.unique(part)]


@given(st.lists(st.tuples(st.sampled_from(sorted(PARTS)), st.floats(0.02, 1.0)), min_size=2, max_size=12),
       st.integers(4, 200))
@settings(max_examples=30, deadline=None)
def test_every_part_keeps_faces_and_its_topology_however_small_the_base(chosen, base):
    m = joined(*[moved(PARTS[name](), size, (5.0 * k, 0, 0)) for k, (name, size) in enumerate(chosen)])
    unit = TriMesh(UnitFrame.of(m.V).to_unit(m.V), m.F)
    out = decimate(unit, base, room=False)
    parts, least = least_faces(m.F)
    assert parts == len(chosen) and len(out.F0) >= least_faces(out.F0)[1] == least
    assert topology_of(out.F0).euler == topology_of(m.F).euler
    assert len(components(TriMesh(out.V0, out.F0))) == parts
    assert len(out.F0) <= max(base, least + 6 * parts) or len(out.F0) == len(m.F)
    assert len(out.F0) == base or out.message.startswith(f"Reached {len(out.F0)} of {base} base faces: ")


def test_tiny_parts_end_at_a_few_faces_and_the_big_one_gets_the_rest():
    small = [moved(sphere(2), 0.01, (2 + 0.1 * k, 0, 0)) for k in range(20)]
    m = joined(sphere(4), *small)
    out = decimate(TriMesh(UnitFrame.of(m.V).to_unit(m.V), m.F), 400)
    sizes = sorted(len(c) for c in components(TriMesh(out.V0, out.F0)))
    assert len(sizes) == 21 and sum(sizes) == 400 and max(sizes[:-1]) <= 8 and sizes[-1] >= 400 - 20 * 8


def test_equal_parts_get_about_equal_shares():
    m = joined(*[sphere(3, at=(3 * k, 0, 0)) for k in range(5)])
    out = decimate(TriMesh(UnitFrame.of(m.V).to_unit(m.V), m.F), 400)
    sizes = [len(c) for c in components(TriMesh(out.V0, out.F0))]
    assert len(sizes) == 5 and min(sizes) > 60 and max(sizes) < 100


def test_parts_that_need_more_than_the_base_are_told():
    many = joined(*[sphere(1, at=(3 * k, 0, 0)) for k in range(50)])
    advice = face_advice(many.F, 199, 0)
    assert (advice.cause, advice.parts, advice.needed) == (Cause.PARTS, 50, 200)
    assert base_message(200, 199, advice) == (
        "Reached 200 of 199 base faces: the 50 separate parts of the mesh need at least 200 base faces, more than the 199 "
        "asked for; ask for more, or join or delete small parts")
    assert face_advice(many.F, 200, 0) == FaceAdvice() == face_advice(tetrahedron().F, 4, 0)
    advice = face_advice(torus().F, 12, 0)
    assert "12 base faces: the handles and borders of the mesh need at least 14 base faces" in base_message(14, 12, advice)


def test_large_parts_get_half_the_faces_asked_for_on_top_of_what_all_need():
    many = joined(*[sphere(1, at=(3 * k, 0, 0)) for k in range(50)])
    assert face_advice(many.F, 100, 0).faces == 0  # it has more faces than that
    pressed = joined(*[tetrahedron(at=(3 * k, 0, 0)) for k in range(50)])
    assert face_advice(pressed.F, 100, 0).faces == 200 + 50


@pytest.mark.parametrize("cause", Cause)
def test_every_cause_has_its_sentence(cause):
    said = base_message(412, 400, FaceAdvice(cause=cause, needed=412, parts=2, handles=3))
    assert said == "" if cause == Cause.NONE else said.startswith("Reached 412 of 400 base faces: ") and len(said) > 50
