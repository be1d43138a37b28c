import numpy as np
import pytest

from npm_blender.core.decimation.qem import decimate
from npm_blender.core.errors import Cancelled
from npm_blender.core.evaluation.metrics import Original
from npm_blender.core.geometry.geodesic_trace import TraceMesh, points_on, trace_geodesic
from npm_blender.core.geometry.normals import vertex_normals
from npm_blender.core.levels.lod_sequence import build_levels
from npm_blender.core.mesh.subdivision import Level, hierarchy
from npm_blender.core.mesh.topology import opposite_halfedges
from npm_blender.core.mesh.triangle_mesh import TriMesh
from npm_blender.core.untangling import rounds as module
from npm_blender.core.untangling.rounds import MESSAGE, untangle
from tests.meshes.lod_meshes import plate, sheet, sphere, torus, tube


def surface_of(mesh):
    return TraceMesh(mesh.V, mesh.F, opposite_halfedges(mesh.F), vertex_normals(mesh))


def flipped(lod):
    out = 0
    for level in hierarchy(lod.F0, len(lod.V0), lod.level_count)[1:]:
        out += ((TriMesh(lod.V, level.F).face_normals() * lod.N[level.F].sum(1)).sum(1) <= 0).sum()
    return out


def test_flipped_faces_are_found_where_something_moved(monkeypatch):
    plain, counts = module._still_flipped, []

    def checked(rings, points, before, since, region, out):
        count = plain(rings, points, before, since, region, out)
        every = np.empty(len(rings.F), np.int64)
        assert np.array_equal(np.sort(out[:count]), every[:module._flipped(rings, points, every)])
        counts.append(count)
        return count

    monkeypatch.setattr(module, "_still_flipped", checked)
    build_levels(decimate(plate(), 100), 3)
    assert len(counts) > 2 and counts[-1] < counts[0]


def test_folded_samples_are_unfolded_and_the_rest_stays():
    mesh = sphere(5)
    plain = build_levels(decimate(mesh, 100), 2)
    H = hierarchy(plain.F0, len(plain.V0), 2)
    assert flipped(plain) == 0
    face, b = plain.source_face.copy(), plain.barycentric.copy()
    rng = np.random.default_rng(1)
    for v in rng.choice(len(face), 5, replace=False):  # far enough to flip faces
        step = np.cross(plain.N[v], rng.normal(size=3))
        face[v] = trace_geodesic(surface_of(mesh), face[v], b[v], *(0.12 * step / np.linalg.norm(step)))
    P = np.einsum("nk,nkd->nd", b, mesh.V[mesh.F[face]])
    N = TriMesh(P, H[-1].F).face_normals()
    assert ((N * P[H[-1].F].mean(1)).sum(1) <= 0).any()
    points = points_on(surface_of(mesh), face, b)
    assert np.array_equal(points.face, face) and np.allclose(points.P, P)
    untangle(surface_of(mesh), points, H, plain.V0)
    Q = np.einsum("nk,nkd->nd", points.b, mesh.V[mesh.F[points.face]])
    N = TriMesh(Q, H[-1].F).face_normals()
    assert ((N * Q[H[-1].F].mean(1)).sum(1) > 0).all()
    assert (np.abs(P - Q).max(1) > 1e-12).sum() < 40


@pytest.mark.parametrize("shape", [sphere, torus, sheet, tube])
def test_noisy_surfaces_have_few_flipped_faces(shape):
    lod = build_levels(decimate(shape(noise=0.002), 60), 3)
    assert flipped(lod) <= 0.001 * 84 * 60


@pytest.mark.parametrize("mesh, base_faces", [(plate(), 100), (sheet(noise=0.01), 60)], ids=["thin plate", "rough sheet"])
def test_hard_surfaces_have_few_flipped_faces_on_every_level(mesh, base_faces):
    lod = build_levels(decimate(mesh, base_faces), 3)
    assert flipped(lod) <= 0.001 * 84 * len(lod.F0)


def test_untangling_does_not_lift_the_faces_off_the_surface(monkeypatch):
    mesh = plate()
    d = decimate(mesh, 100)
    finest = hierarchy(d.F0, len(d.V0), 3)[-1]
    untangled = build_levels(d, 3, fitted=False)
    monkeypatch.setattr("npm_blender.core.levels.lod_sequence.untangle", lambda surface, points, levels, base, progress: None)
    plain = build_levels(d, 3, fitted=False)
    assert flipped(untangled) < 0.2 * flipped(plain)
    before, after = (Original(mesh, 5000).evaluate(TriMesh(lod.V, finest.F)) for lod in (plain, untangled))
    assert after.d_pm <= 1.01 * before.d_pm and after.d_normal < before.d_normal


def test_work_bounds_single_steps_too(monkeypatch):
    d = decimate(plate(), 100)
    full = flipped(build_levels(d, 3))
    monkeypatch.setattr("npm_blender.core.untangling.rounds.WORK", 300)
    some = flipped(build_levels(d, 3))
    monkeypatch.setattr("npm_blender.core.untangling.rounds.WORK", 0)
    assert full < some < flipped(build_levels(d, 3))


def test_the_same_points_on_every_run():
    d = decimate(plate(), 100)
    one, two = build_levels(d, 3), build_levels(d, 3)
    assert np.array_equal(one.V, two.V) and np.array_equal(one.source_face, two.source_face)


def test_a_surface_that_takes_long_can_be_cancelled_and_slices_change_nothing(monkeypatch):
    d = decimate(plate(), 100)
    one, seen = build_levels(d, 3), []
    monkeypatch.setattr("npm_blender.core.untangling.rounds.SLICE", 30)
    two = build_levels(d, 3, progress=lambda fraction, message: seen.append(fraction) if message == MESSAGE else None)
    assert np.array_equal(one.V, two.V) and len(seen) > 10 and all(0.6 <= fraction <= 0.65 for fraction in seen)

    def cancel(fraction, message):
        if message == MESSAGE and fraction > 0.6:
            raise Cancelled("enough")

    with pytest.raises(Cancelled):
        build_levels(d, 3, progress=cancel)


def test_border_vertices_do_not_move():
    mesh = sheet(noise=0.01)
    d = decimate(mesh, 40)
    H = hierarchy(d.F0, len(d.V0), 2)
    lod = build_levels(d, 2)
    last: Level = H[-1]
    border = np.unique(last.F.reshape(-1)[last.opposite == np.arange(last.F.size)])
    rng = np.random.default_rng(0)
    face = rng.integers(0, len(mesh.F), last.n).astype(np.int32)
    face[border] = lod.source_face[border]
    points = points_on(surface_of(mesh), face, lod.barycentric)
    untangle(surface_of(mesh), points, H, lod.V0)
    assert np.array_equal(points.face[border], face[border])
    assert np.allclose(points.b[border], lod.barycentric[border])
    assert (points.b >= 0).all() and np.allclose(points.b.sum(1), 1)
