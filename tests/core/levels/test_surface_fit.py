import numpy as np
import pytest

from npm_blender.core.decimation.qem import decimate
from npm_blender.core.evaluation.metrics import Original
from npm_blender.core.levels.lod_sequence import build_levels
from npm_blender.core.mesh.subdivision import hierarchy
from npm_blender.core.mesh.triangle_mesh import TriMesh
from tests.meshes.lod_meshes import block, plate, sheet, sphere, torus


def pair(mesh, base_faces=100, depth=2):
    """The input's errors, the finest mesh sampled and the finest mesh fitted."""
    d = decimate(mesh, base_faces)
    both = [build_levels(d, depth, fitted=fitted) for fitted in (False, True)]
    finest = hierarchy(both[0].F0, len(both[0].V0), depth)[-1]
    return Original(mesh, 5000), *(TriMesh(lod.V, finest.F) for lod in both)


@pytest.mark.parametrize("shape", [sphere, torus, sheet])
def test_fitting_lowers_the_error_both_ways_and_keeps_the_normals(shape):
    original, sampled, fitted = pair(shape())
    before, after = original.evaluate(sampled), original.evaluate(fitted)
    assert after.d_pm < 0.8 * before.d_pm and after.d_reverse < 0.8 * before.d_reverse
    assert after.d_normal < 1.02 * before.d_normal


def test_vertices_slide_to_the_edges_of_a_box():
    original, sampled, fitted = pair(block(), 60)
    before, after = original.evaluate(sampled), original.evaluate(fitted)
    assert after.d_reverse < 0.5 * before.d_reverse and after.d_normal < 0.7 * before.d_normal


def test_border_vertices_stay_where_the_map_puts_them():
    d = decimate(sheet(), 40)
    sampled, fitted = build_levels(d, 3, fitted=False), build_levels(d, 3)
    finest = hierarchy(sampled.F0, len(sampled.V0), 3)[-1]
    border = np.unique(finest.F.reshape(-1)[finest.opposite == np.arange(finest.F.size)])
    assert np.array_equal(sampled.V[border], fitted.V[border]) and np.abs(sampled.V - fitted.V).max() > 1e-5


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_no_face_turns_over_that_the_sampling_left_upright(noise):
    _, sampled, fitted = pair(torus(noise=noise), 100, 3)
    cosine = (sampled.face_normals() * fitted.face_normals()).sum(1)
    assert (cosine < 0).mean() < 0.002


@pytest.mark.parametrize("mesh", [torus(noise=0.01), plate(), block()], ids=["rough torus", "thin plate", "block"])
def test_the_fit_turns_over_no_face_that_the_map_leaves_upright(mesh):
    d = decimate(mesh, 100)
    sampled, fitted = build_levels(d, 3, fitted=False), build_levels(d, 3)
    for level in hierarchy(d.F0, len(d.V0), 3)[1:]:
        N = sampled.N[level.F].sum(1)
        before, after = ((TriMesh(lod.V[:level.n], level.F).face_normals() * N).sum(1) for lod in (sampled, fitted))
        assert not ((before > 1e-9) & (after < -1e-9)).any()


def test_a_surface_that_the_level_meets_exactly_is_left_alone():
    _, sampled, fitted = pair(sheet(flat=True), 40)
    assert np.abs(sampled.V - fitted.V)[:, 2].max() < 1e-12
