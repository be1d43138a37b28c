import numpy as np
import pytest

from npm_blender.core.decimation.qem import decimate
from npm_blender.core.errors import MeshError
from npm_blender.core.levels.level_points import level_corners
from npm_blender.core.levels.lod_sequence import build_levels, build_lod
from npm_blender.core.mesh.renumbering import Renumbering
from npm_blender.core.mesh.subdivision import hierarchy, midpoints
from npm_blender.core.mesh.topology import opposite_halfedges
from npm_blender.core.mesh.triangle_mesh import TriMesh
from npm_blender.core.settings import LodSettings
from tests.meshes.lod_meshes import sheet, sphere, torus, tube


def settings_for(base_faces, depth=3):
    return LodSettings(base_faces=base_faces, levels=depth)


def on_surface(mesh, lod):
    return np.einsum("nk,nkd->nd", lod.barycentric, mesh.V[mesh.F[lod.source_face]])


@pytest.mark.parametrize("shape", [sphere, torus, sheet, tube])
@pytest.mark.parametrize("depth", [1, 3])
def test_a_sequence_has_consistent_fields(shape, depth):
    mesh = shape()
    lod = build_lod(mesh, settings_for(100, depth))
    H = hierarchy(lod.F0, len(lod.V0), depth)
    assert lod.level_count == depth and lod.message == ""
    assert len(lod.V) == len(lod.N) == len(lod.source_face) == len(lod.barycentric) == H[-1].n
    sampled = build_levels(decimate(mesh, 100), depth, fitted=False)
    assert np.allclose(on_surface(mesh, sampled), sampled.V, atol=1e-12)
    assert np.allclose(on_surface(mesh, lod), sampled.V, atol=1e-12) and np.array_equal(lod.N, sampled.N)
    assert np.allclose(np.linalg.norm(lod.N, axis=1), 1)
    assert lod.V0.dtype == lod.V.dtype == lod.N.dtype == lod.barycentric.dtype == np.float64
    assert lod.F0.dtype == lod.source_face.dtype == np.int32


def test_finer_levels_come_closer_to_the_sphere_without_flips():
    lod = build_lod(sphere(5), settings_for(200))
    errors = []
    for level in hierarchy(lod.F0, len(lod.V0), 3):
        mesh = TriMesh(lod.V[:level.n], level.F)
        errors.append(np.abs(np.linalg.norm(mesh.V[mesh.F].mean(1), axis=1) - 0.5).mean())
        assert ((mesh.face_normals() * lod.N[level.F].sum(1)).sum(1) > 0).all()
    assert all(fine < 0.5 * coarse for coarse, fine in zip(errors[:-1], errors[1:], strict=True))


def test_the_vertices_of_a_level_are_a_prefix_of_the_finer_ones():
    d = decimate(torus(), 100)
    coarse, fine = build_levels(d, 1, fitted=False), build_levels(d, 3, fitted=False)
    assert np.allclose(coarse.V, fine.V[:len(coarse.V)], atol=1e-9)


def test_a_mesh_that_is_not_decimated_maps_to_itself():
    mesh = sphere(1)
    lod = build_levels(decimate(mesh, 400), 2)
    V = mesh.V
    for level in hierarchy(mesh.F, len(mesh.V), 2)[:-1]:
        V = midpoints(V, level)
    assert np.allclose(lod.V, V) and np.array_equal(lod.F0, mesh.F)


def test_border_vertices_lie_on_the_border():
    mesh = sheet(flat=True)
    lod = build_lod(mesh, settings_for(40))
    last = hierarchy(lod.F0, len(lod.V0), 3)[-1]
    border = np.unique(last.F.reshape(-1)[last.opposite == np.arange(len(last.opposite))])
    low, high = mesh.V.min(0), mesh.V.max(0)
    distance = np.minimum(np.abs(lod.V - low), np.abs(lod.V - high))[:, :2].min(1)
    assert distance[border].max() < 1e-9
    # both ways: the corners of the outline are met within the spacing of the border vertices
    corners = np.array([[x, y, 0] for x in (low[0], high[0]) for y in (low[1], high[1])])
    assert np.linalg.norm(corners[:, None] - lod.V[border][None], axis=2).min(1).max() < 0.1


def test_an_order_renumbers_the_same_sequence():
    d = decimate(torus(noise=0.003), 100)
    rng = np.random.default_rng(3)
    vertices, faces = rng.permutation(len(d.V0)), rng.permutation(len(d.F0))
    new_of_old = np.argsort(vertices)
    F = new_of_old[d.F0[faces]]
    F = np.stack([np.roll(f, k) for f, k in zip(F, rng.integers(0, 3, len(F)), strict=True)]).astype(np.int32)
    plain, ordered = build_levels(d, 2), build_levels(d, 2, Renumbering(vertices, faces, F))
    assert np.array_equal(ordered.F0, F) and np.array_equal(ordered.V0, d.V0[vertices])
    for level in hierarchy(ordered.F0, len(ordered.V0), 2)[1:]:
        assert level.n <= len(ordered.V)
    assert np.allclose(ordered.V[:len(d.V0)], plain.V[:len(d.V0)][vertices], atol=1e-6)
    rounded = [np.unique(np.round(lod.V, 5), axis=0) for lod in (plain, ordered)]
    assert len(rounded[0]) == len(plain.V) and np.allclose(*rounded, atol=1e-4)
    # a new edge vertex lies between its ends, so the midpoints prediction fits as well as it did
    level = hierarchy(ordered.F0, len(ordered.V0), 1)[0]
    gap = np.abs(midpoints(ordered.V[:level.n], level) - ordered.V[:level.n + len(level.edges)]).max()
    old = hierarchy(plain.F0, len(plain.V0), 1)[0]
    expected = np.abs(midpoints(plain.V[:old.n], old) - plain.V[:old.n + len(old.edges)]).max()
    assert gap == pytest.approx(expected, abs=1e-5)


def test_level_corners_follow_the_subdivision():
    F = np.array([[0, 1, 2]], np.int32)
    V = np.eye(3)
    H = hierarchy(F, 3, 2)
    for level in H[:-1]:
        V = midpoints(V, level)
    assert np.allclose(level_corners(2), V[H[-1].F])


def test_unreached_target_is_told():
    lod = build_lod(sphere(1), settings_for(400, 1))
    assert lod.message == "Reached 32 of 400 base faces: the mesh has no more"


def test_progress_ends_at_one():
    seen = []
    build_lod(sphere(4), settings_for(100), lambda f, m: seen.append((f, m)))
    assert [f for f, _ in seen] == sorted(f for f, _ in seen) and seen[-1] == (1.0, "Mapping the levels")


def test_two_faces_turned_against_each_other_are_refused():
    with pytest.raises(MeshError, match="oriented manifold"):
        build_lod(TriMesh.from_arrays(np.eye(4)[:, :3], np.array([[0, 1, 2], [0, 1, 3]])), settings_for(4, 1))


def test_one_triangle_is_a_sequence_of_its_own():
    mesh = TriMesh.from_arrays(np.eye(3), np.array([[0, 1, 2]]))
    lod = build_lod(mesh, settings_for(4, 2))
    assert len(lod.V) == 15 and np.allclose(lod.V.sum(1), 1)
    assert (opposite_halfedges(lod.F0) == np.arange(3)).all()
