"""Jagged borders keep as many base edges as their corners need, and give them up where the faces asked for need that."""
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.cleaning.cleanup import clean
from npm_blender.core.decimation import border_corners
from npm_blender.core.decimation import decimator as module
from npm_blender.core.decimation.border_corners import ALLOWED, LOSS, REFUSED, SEGMENTS, Corners
from npm_blender.core.decimation.decimator import half_edges_with_quadrics
from npm_blender.core.decimation.qem import decimate
from npm_blender.core.levels.lod_sequence import build_lod
from npm_blender.core.mesh.subdivision import hierarchy
from npm_blender.core.mesh.topology import topology_of
from npm_blender.core.mesh.triangle_mesh import TriMesh, UnitFrame
from npm_blender.core.settings import AUTO, LodSettings
from tests.core.levels.test_border_sampling import border_loops
from tests.meshes.dirty_meshes import plane, sphere, tube, wave, without


def pierced(holes, seed=0, levels=5, size=0.06, roughness=0.3):
    """A sphere with that many small jagged holes."""
    rng = np.random.default_rng(seed)
    m = sphere(levels)
    k = np.arange(holes) + 0.5
    z, w = 1 - 2 * k / holes, np.pi * (1 + 5**0.5) * k
    radius = np.linalg.norm(m.V, axis=1).mean()
    centres = radius * np.stack([np.sqrt(1 - z**2) * np.cos(w), np.sqrt(1 - z**2) * np.sin(w), z], 1)
    apart = np.linalg.norm(m.V[m.F].mean(1)[:, None] - centres, axis=2).min(1)
    m = without(m, np.flatnonzero(apart < 2 * radius * size))
    edges, _ = border_loops(m)
    step = np.linalg.norm(m.V[edges[:, 0]] - m.V[edges[:, 1]], axis=1).mean()
    V = m.V.copy()
    rim = np.unique(edges)
    V[rim] += rng.normal(0, roughness * step, (len(rim), 3))
    cleaned, _ = clean(TriMesh.from_arrays(V, m.F))
    return TriMesh(UnitFrame.of(cleaned.V).to_unit(cleaned.V), cleaned.F)


def lengths(V, F):
    """Length of each border loop, sorted."""
    edges, loop = border_loops(TriMesh(V, F))
    return np.sort(np.bincount(loop, np.linalg.norm(V[edges[:, 0]] - V[edges[:, 1]], axis=1)))


def shortest(mesh, base_faces):
    """The least length of a border loop of M^3 over the input's."""
    lod = build_lod(mesh, LodSettings(base_faces=base_faces, levels=3))
    there = lengths(lod.V, hierarchy(lod.F0, len(lod.V0), 3)[-1].F)
    return (there / lengths(mesh.V, mesh.F)).min()


def same(a, b):
    return np.array_equal(a.V0, b.V0) and np.array_equal(a.F0, b.F0) and a.message == b.message


@pytest.mark.slow
@pytest.mark.parametrize("base_faces", [150, 400, AUTO])
@settings(max_examples=2, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 6))
def test_small_jagged_holes_keep_their_length(base_faces, seed, holes):
    assert shortest(pierced(holes, seed), base_faces) > 0.98


def test_they_would_not_with_three_edges_each(monkeypatch):
    mesh = pierced(3)
    kept = shortest(mesh, 150)
    monkeypatch.setattr(border_corners, "SEGMENTS", 10**6)
    assert shortest(mesh, 150) < 0.97 and kept > 0.98


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 40), st.integers(4, 300), st.integers(0, 3))
def test_every_corner_is_counted_and_no_edge_has_more_than_it_may(seed, holes, base_faces, variant):
    mesh = pierced(holes, seed, levels=4)
    seen = []

    class Spy(Corners):
        @staticmethod
        def of(halfedges, faces):
            seen.append((halfedges, Corners.of(halfedges, faces)))
            return seen[-1][1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "Corners", Spy)
        decimate(mesh, base_faces, variant)
    before = Corners.of(half_edges_with_quadrics(mesh)[0], base_faces).marked.sum()
    for halfedges, corners in seen:
        h = np.flatnonzero((halfedges.opposite == np.arange(len(halfedges.opposite))) & (halfedges.corner >= 0))
        inside = corners.count[halfedges.edge[h]]
        assert inside.sum() + corners.marked[halfedges.corner[h]].sum() == before
        assert inside.max() <= corners.limits[ALLOWED]
        for e in halfedges.edge[h]:
            found = [corners.first[e]]
            while found[-1] >= 0:
                found.append(corners.next[found[-1]])
            assert len(found) - 1 == corners.count[e] and (np.abs(corners.share[found[:-1]] - 0.5) <= 0.5).all()


@pytest.mark.parametrize("holes, base_faces", [(1, 4), (2, 4), (12, 4), (12, 60), (40, 100), (40, 201), (40, 400), (3, 21)])
def test_the_number_of_faces_is_that_without_the_corners(holes, base_faces, monkeypatch):
    mesh = pierced(holes, levels=4)
    with_corners = decimate(mesh, base_faces)
    monkeypatch.setattr(border_corners, "SEGMENTS", 10**6)
    without_corners = decimate(mesh, base_faces)
    assert len(with_corners.F0) == len(without_corners.F0) and with_corners.message == without_corners.message
    a, b = topology_of(with_corners.F0), topology_of(mesh.F)
    assert (a.euler, a.border_loops) == (b.euler, b.border_loops)


@pytest.mark.parametrize("base_faces", [60, 400, AUTO])
def test_closed_meshes_and_smooth_borders_stay_as_they_were(base_faces, monkeypatch):
    found = [[decimate(m, base_faces) for m in (sphere(4), plane(30), wave(30), tube(20, 60))]]
    monkeypatch.setattr(border_corners, "SEGMENTS", 10**6)
    found.append([decimate(m, base_faces) for m in (sphere(4), plane(30), wave(30), tube(20, 60))])
    assert all(same(a, b) for a, b in zip(*found, strict=True))


def test_a_closed_mesh_has_nothing_to_count(monkeypatch):
    one = decimate(sphere(4), 100)
    monkeypatch.setattr(border_corners, "SEGMENTS", 0)
    assert same(one, decimate(sphere(4), 100))


def test_a_square_has_four_corners():
    mesh = plane(20)
    corners = Corners.of(half_edges_with_quadrics(mesh)[0], 400)
    at = mesh.V[corners.marked][:, :2]
    assert {tuple(p) for p in at.round(9).tolist()} == {(0, 0), (0, 1), (1, 0), (1, 1)}
    assert corners.limits[ALLOWED] == SEGMENTS - 1 and not corners.count.any()


@given(st.integers(0, 10**6), st.floats(0, 2))
@settings(max_examples=20, deadline=None)
def test_the_corners_alone_are_as_long_as_the_loop(seed, roughness):
    mesh = pierced(2, seed, levels=4, roughness=roughness)
    marked = Corners.of(half_edges_with_quadrics(mesh)[0], 400).marked
    edges, loop = border_loops(mesh)
    after = dict(edges.tolist())
    for k in np.unique(loop):
        start = int(edges[loop == k][0, 0])
        chain = [start]
        while after[chain[-1]] != start:
            chain.append(after[chain[-1]])
        whole, some = (mesh.V[np.array(c)] for c in (chain, [v for v in chain if marked[v]]))
        long, short = (np.linalg.norm(P - np.roll(P, -1, 0), axis=1).sum() for P in (whole, some))
        assert len(some) >= 3 and (1 - LOSS) * long <= short * (1 + 1e-12)


def test_more_corners_than_the_base_has_room_for_get_a_share_of_it():
    mesh = pierced(40, levels=5)
    corners = [Corners.of(half_edges_with_quadrics(mesh)[0], n) for n in (10, 100, 400)]
    most = [c.limits[ALLOWED] for c in corners]
    assert most[0] > most[1] > SEGMENTS - 1
    assert corners[0].marked.sum() / most[0] == pytest.approx(border_corners.SHARE * 10)


def test_refused_collapses_are_allowed_one_after_the_other():
    corners = Corners.of(half_edges_with_quadrics(plane(3))[0], 400)
    assert not corners.yield_to() and corners.limits[ALLOWED] == SEGMENTS - 1
    corners.limits[REFUSED] = 20.0
    assert corners.yield_to() and corners.limits[ALLOWED] == 20.0
    corners.limits[REFUSED] = 20.5
    assert corners.yield_to() and corners.limits[ALLOWED] == 25.0 and not corners.yield_to()
