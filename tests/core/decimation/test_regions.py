"""A mesh decimated by its regions: the same promises as without them, whatever the number of threads."""
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.decimation import qem as module
from npm_blender.core.decimation import regions
from npm_blender.core.decimation.decimator import Decimator
from npm_blender.core.decimation.qem import decimate
from npm_blender.core.errors import Cancelled
from npm_blender.core.evaluation.metrics import Original
from npm_blender.core.mesh.topology import opposite_halfedges, topology_of
from npm_blender.core.mesh.triangle_mesh import TriMesh, UnitFrame
from npm_blender.core.parameterization.collapse_record import FIRST, SIDES
from npm_blender.core.settings import AUTO
from tests.meshes.lod_meshes import joined, sheet, sphere, torus, tube
from tests.meshes.shapes import bumpy

SHAPES = {"sphere": lambda **k: sphere(5, **k), "torus": lambda **k: torus(40, 60, **k),
          "sheet": lambda **k: sheet(51, 61, **k), "tube": lambda **k: tube(60, 60, **k),
          "several": lambda **k: joined(sphere(4, **k), torus(40, 60, **k))}


@pytest.fixture(autouse=True)
def small_regions(monkeypatch):
    """Regions of 500 faces where a real one has 32,000."""
    monkeypatch.setattr(regions, "SMALLEST", 500)


@pytest.fixture
def whole(monkeypatch):
    """Decimates a mesh without regions."""
    def run(*arguments):
        with monkeypatch.context() as patch:
            patch.setattr(module, "worth_dividing", lambda faces, base_faces: False)
            return decimate(*arguments)
    return run


def arrays(out):
    return out.V0, out.F0, out.vertices, out.faces, *out.record


def at(V, F, face, b):
    return np.einsum("nk,nkd->nd", b, V[F[face]])


def unit(mesh):
    return TriMesh(UnitFrame.of(mesh.V).to_unit(mesh.V), mesh.F)


@settings(max_examples=8, deadline=None)
@given(st.sampled_from(sorted(SHAPES)), st.integers(0, 99), st.integers(16, 40), st.integers(0, 2))
def test_topology_target_and_map_hold(shape, seed, target, variant):
    mesh = SHAPES[shape](noise=0.003, seed=seed)
    assert regions.worth_dividing(len(mesh.F), target)
    out = decimate(mesh, target, variant)
    one, two = topology_of(mesh.F), topology_of(out.F0)
    assert (one.euler, one.components, one.border_loops) == (two.euler, two.components, two.border_loops)
    assert len(out.F0) == target - (target % 2 and not one.border_loops) or out.message
    random = np.random.default_rng(seed)
    face, b = random.integers(0, len(out.F0), 300), random.dirichlet(np.ones(3), 300)
    back = out.surface_map.fine_to_coarse(*out.surface_map.coarse_to_fine(face, b))
    assert np.abs(at(out.V0, out.F0, face, b) - at(out.V0, out.F0, *back)).max() < 1e-6


@pytest.mark.parametrize("variant", [0, 3])
def test_the_number_of_threads_changes_nothing(variant, monkeypatch):
    mesh, found = unit(bumpy(5)), []
    for count in ("1", "2", "7"):
        monkeypatch.setenv("OMP_NUM_THREADS", count)
        found.append(arrays(decimate(mesh, 40, variant)))
    for other in found[1:]:
        assert all(np.array_equal(a, b) for a, b in zip(found[0], other, strict=True))


def test_the_regions_do_most_of_the_work(whole, monkeypatch):
    mesh, left = unit(bumpy(5)), []
    offer_all = Decimator.offer_all
    monkeypatch.setattr(Decimator, "offer_all", lambda self: (left.append(self.faces), offer_all(self))[1])
    decimate(mesh, 20)
    divided = left[0]
    left.clear()
    whole(mesh, 20)
    assert left[0] == len(mesh.F) and divided < 0.4 * len(mesh.F)


def test_the_base_is_as_near_as_without_regions(whole):
    mesh = unit(bumpy(5))
    original = Original(mesh, 20_000)
    errors = [original.evaluate(TriMesh(d.V0, d.F0)).d_pm for d in (decimate(mesh, 40), whole(mesh, 40))]
    assert errors[0] < 1.1 * errors[1]


def test_detail_in_one_place_keeps_its_faces():
    """A flat sheet with a bump: the bump's region may be as fine as if the rest were not there."""
    mesh = sheet(101, 101, flat=True)
    V = mesh.V.copy()
    r = np.linalg.norm(V[:, :2] - [0.25, 0.25], axis=1) / 0.1
    V[:, 2] += 0.1 * np.cos(np.pi / 2 * np.minimum(r, 1)) ** 2 * (r < 1) * np.cos(9 * r)
    out = decimate(TriMesh(V, mesh.F), 100)
    centre = out.V0[out.F0].mean(1)
    assert (np.linalg.norm(centre[:, :2] - [0.25, 0.25], axis=1) < 0.12).sum() > 60


def test_the_automatic_base_is_about_the_same(whole, monkeypatch):
    monkeypatch.setattr(module, "MOST", 100)
    mesh = unit(bumpy(5))
    assert regions.worth_dividing(len(mesh.F), 100)
    assert len(decimate(mesh, AUTO).F0) == pytest.approx(len(whole(mesh, AUTO).F0), rel=0.1)


@pytest.mark.parametrize("shape", SHAPES)
def test_each_face_but_those_of_the_base_vanishes_once_and_is_not_touched_again(shape):
    out = decimate(SHAPES[shape](), 20)
    c, faces = out.record.collapses, out.record.faces >> 2
    at = np.arange(len(faces)) - np.repeat(c[:-1, FIRST], np.diff(c[:, FIRST]))
    vanishes = at >= np.repeat(c[:-1, SIDES], np.diff(c[:, FIRST]))
    assert np.array_equal(np.sort(faces[vanishes]), np.setdiff1d(np.arange(len(out.mesh.F)), out.faces))
    last = np.zeros(len(out.mesh.F), int)
    last[faces] = np.arange(len(faces))  # of several places the last one counts
    assert np.array_equal(np.sort(last[faces[vanishes]]), np.flatnonzero(vanishes))


def test_the_vertices_of_a_border_stay_while_regions_are_decimated(monkeypatch):
    mesh, seen, offer_all = sheet(51, 61), [], Decimator.offer_all
    monkeypatch.setattr(Decimator, "offer_all", lambda self: (seen.append(self.mesh.out >= 0), offer_all(self))[1])
    decimate(mesh, 16)
    h = np.flatnonzero(opposite_halfedges(mesh.F) == np.arange(mesh.F.size))
    on_border = mesh.F.reshape(-1)[h]
    assert len(on_border) == 2 * (51 + 61) - 4
    assert seen[0][on_border].all() and not seen[0].all()


def test_cancel_reaches_the_regions():
    def progress(share, message):
        if share > 0.2:
            raise Cancelled()

    with pytest.raises(Cancelled):
        decimate(unit(bumpy(5)), 20, 0, progress)


def test_progress_rises_to_its_end():
    seen = []
    decimate(unit(bumpy(5)), 20, 0, lambda share, message: seen.append(share))
    assert seen[0] == 0 and seen[-1] == pytest.approx(1, abs=0.01) and min(np.diff(seen)) >= 0
