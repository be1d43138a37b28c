import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.decimation.qem import decimate
from npm_blender.core.mesh.topology import opposite_halfedges
from npm_blender.core.parameterization.collapse_record import AT, FIRST, RING, SIDES
from npm_blender.core.parameterization.joint_flattening import twice_area
from npm_blender.core.parameterization.recorded_stencil import recorded_stencil, triangle_corners
from tests.meshes.lod_meshes import joined, sheet, sphere, torus, tube

SHAPES = {"sphere": sphere, "torus": torus, "sheet": sheet, "tube": tube}


def points(mesh_faces, count, seed):
    rng = np.random.default_rng(seed)
    return rng.integers(0, mesh_faces, count), rng.dirichlet(np.ones(3), count)


def at(V, F, face, b):
    return np.einsum("nk,nkd->nd", b, V[F[face]])


@settings(max_examples=30, deadline=None)
@given(st.sampled_from(sorted(SHAPES)), st.integers(0, 99), st.floats(0, 0.02), st.integers(20, 300), st.integers(0, 2))
def test_coarse_to_fine_and_back_is_the_identity(shape, seed, noise, target, variant):
    out = decimate(SHAPES[shape](noise=noise, seed=seed), target, variant)
    face, b = points(len(out.F0), 300, seed)
    back = out.surface_map.fine_to_coarse(*out.surface_map.coarse_to_fine(face, b))
    there, here = at(out.V0, out.F0, face, b), at(out.V0, out.F0, *back)
    assert np.abs(there - here).max() < 1e-6


@pytest.mark.parametrize("shape", SHAPES)
def test_fine_to_coarse_and_back_is_the_identity(shape):
    mesh = SHAPES[shape](noise=0.005)
    out = decimate(mesh, 100)
    face, b = points(len(mesh.F), 2000, 1)
    back = out.surface_map.coarse_to_fine(*out.surface_map.fine_to_coarse(face, b))
    assert np.abs(at(mesh.V, mesh.F, face, b) - at(mesh.V, mesh.F, *back)).max() < 1e-6


def test_barycentrics_are_convex_and_faces_in_range():
    mesh = torus()
    out = decimate(mesh, 60)
    face, b = out.surface_map.coarse_to_fine(*points(60, 5000, 2))
    assert (b >= 0).all() and np.allclose(b.sum(1), 1) and face.min() >= 0 and face.max() < len(mesh.F)
    face, b = out.surface_map.fine_to_coarse(*points(len(mesh.F), 5000, 3))
    assert (b >= 0).all() and np.allclose(b.sum(1), 1) and face.min() >= 0 and face.max() < 60


def test_the_map_stays_near_and_covers_the_surface():
    mesh = sphere(4)
    out = decimate(mesh, 400)
    face, b = points(400, 20000, 4)
    on, fine = at(out.V0, out.F0, face, b), out.surface_map.coarse_to_fine(face, b)
    assert np.linalg.norm(on - at(mesh.V, mesh.F, *fine), axis=1).max() < 0.08
    assert len(np.unique(fine[0])) > 0.95 * len(mesh.F)


def test_a_shared_edge_maps_to_the_same_points_from_both_sides():
    mesh = torus(noise=0.005)
    out = decimate(mesh, 100)
    opposite = opposite_halfedges(out.F0)
    h = np.arange(300)
    s = 0.3
    one, two = np.zeros((300, 3)), np.zeros((300, 3))
    one[h, h % 3], one[h, (h + 1) % 3] = 1 - s, s
    o = opposite[h]
    two[h, o % 3], two[h, (o + 1) % 3] = s, 1 - s
    a, b = out.surface_map.coarse_to_fine(h // 3, one), out.surface_map.coarse_to_fine(o // 3, two)
    assert np.abs(at(mesh.V, mesh.F, *a) - at(mesh.V, mesh.F, *b)).max() < 1e-6


@pytest.mark.parametrize("shape", ["sheet", "tube"])
def test_the_border_maps_onto_the_border_in_order(shape):
    mesh = SHAPES[shape](noise=0.003)
    out = decimate(mesh, 60)
    coarse, fine = opposite_halfedges(out.F0), opposite_halfedges(mesh.F)
    for h in np.flatnonzero(coarse == np.arange(len(coarse))):
        s = np.linspace(0, 1, 9)[1:-1]
        b = np.zeros((len(s), 3))
        b[:, h % 3], b[:, (h % 3 + 1) % 3] = 1 - s, s
        face, b = out.surface_map.coarse_to_fine(np.full(len(s), h // 3), b)
        for f, w in zip(face, b, strict=True):
            sides = [3 * f + k for k in range(3) if w[(k + 2) % 3] == 0]
            assert any(fine[g] == g for g in sides) or (w == 1).any()


def test_components_do_not_mix():
    mesh = joined(sphere(2), torus(), sheet())
    out = decimate(mesh, 120)
    face, b = points(120, 2000, 5)
    base, fine = at(out.V0, out.F0, face, b), at(mesh.V, mesh.F, *out.surface_map.coarse_to_fine(face, b))
    assert np.linalg.norm(base - fine, axis=1).max() < 0.15


def test_no_points_give_no_points():
    out = decimate(sphere(), 60)
    face, b = out.surface_map.coarse_to_fine(np.zeros(0, np.int32), np.zeros((0, 3)))
    assert face.shape == (0,) and b.shape == (0, 3)


@settings(max_examples=15, deadline=None)
@given(st.sampled_from(sorted(SHAPES)), st.integers(0, 99), st.floats(0, 0.03))
def test_the_map_holds_down_to_the_smallest_base(shape, seed, noise):
    mesh = SHAPES[shape](noise=noise, seed=seed)
    out = decimate(mesh, 4)
    face, b = points(len(mesh.F), 500, seed)
    back = out.surface_map.coarse_to_fine(*out.surface_map.fine_to_coarse(face, b))
    assert np.abs(at(mesh.V, mesh.F, face, b) - at(mesh.V, mesh.F, *back)).max() < 1e-4


@pytest.mark.parametrize("shape", SHAPES)
def test_every_flattening_is_positively_oriented_on_both_sides(shape):
    record = decimate(SHAPES[shape](noise=0.03), 4).record
    for c in range(len(record.collapses) - 1):
        first, stop = record.collapses[c:c + 2, FIRST]
        for q in range(stop - first):
            for before in (True, False) if q < record.collapses[c, SIDES] else (True,):
                corners = triangle_corners(recorded_stencil(record, c), q, before)
                assert twice_area(*(record.uv[k] for k in corners)) > 0


def off(points, path):
    """Largest distance of complex points to a path."""
    a, d = np.array(path[:-1]), np.diff(path)
    z = np.array(points)[:, None] - a
    share = np.clip((z * d.conj()).real / np.abs(d) ** 2, 0, 1)
    return np.abs(z - share * d).min(1).max()


@settings(max_examples=20, deadline=None)
@given(st.sampled_from(["sheet", "tube"]), st.integers(0, 99), st.floats(0, 0.03))
def test_the_border_through_a_stencil_is_the_same_line_on_both_sides(shape, seed, noise):
    record = decimate(SHAPES[shape](noise=noise, seed=seed), 4).record
    for c in range(len(record.collapses) - 1):
        r, t, at = record.collapses[c, [RING, SIDES, AT]]
        if r == t:
            continue
        first, last, (i, j, k) = record.uv[at], record.uv[at + r - 1], record.uv[at + r:at + r + 3]
        one = record.collapses[c + 1, FIRST] - record.collapses[c, FIRST] == t + 1
        before, after = [last, i, *([j] if one else []), first], [last, k, first]
        assert max(off(before, after), off(after, before)) < 1e-9
        assert np.abs(np.diff(before)).sum() == pytest.approx(np.abs(np.diff(after)).sum())
