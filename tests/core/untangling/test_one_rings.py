import numpy as np
import pytest

from npm_blender.core.decimation.qem import decimate
from npm_blender.core.geometry.face_orientation import MARGIN, is_flipped, orientation_cosine, orientation_measures
from npm_blender.core.geometry.geodesic_trace import SurfacePoints
from npm_blender.core.levels.lod_sequence import build_levels
from npm_blender.core.mesh.subdivision import hierarchy
from npm_blender.core.untangling.one_rings import one_rings_of
from npm_blender.core.untangling.vertex_moves import score
from tests.meshes.lod_meshes import sheet, sphere


@pytest.fixture(params=[sphere, sheet], ids=["closed", "open"])
def case(request):
    """Levels, their rings, and points thrown about, so that many faces are turned."""
    lod = build_levels(decimate(request.param(), 40), 2)
    H = hierarchy(lod.F0, len(lod.V0), 2)
    rng = np.random.default_rng(3)
    V = lod.V + rng.normal(scale=0.03, size=lod.V.shape)
    return H, one_rings_of(H), SurfacePoints(lod.source_face, lod.barycentric, V, lod.N)


def test_rings_hold_the_faces_round_each_free_vertex_in_order(case):
    H, rings, _ = case
    for k, level in enumerate(H[1:]):
        for v in range(level.n):
            here = slice(rings.at[k, v], rings.at[k, v + 1])
            around, faces = rings.around[here], rings.faces[here]
            if rings.fixed[v]:
                assert len(around) == 0
                continue
            assert set(faces) == set(rings.first[k] + np.flatnonzero((level.F == v).any(1)))
            for f, p, q in zip(faces, around, np.roll(around, -1)):
                corner = list(rings.F[f]).index(v)
                assert list(np.roll(rings.F[f], -corner)) == [v, p, q]


def test_parents_are_the_ends_of_the_edge_that_a_vertex_halves(case):
    H, rings, _ = case
    assert (rings.parents[:H[0].n] == -1).all()
    for level in H[:-1]:
        assert np.array_equal(rings.parents[level.n:level.n + len(level.edges)], level.edges)


def test_a_face_is_turned_where_its_cosine_is_at_most_the_margin(case):
    _, rings, points = case
    cosines = np.array([orientation_cosine(rings.F, points.P, points.N, f) for f in range(len(rings.F))])
    found = np.array([is_flipped(rings.F, points.P, points.N, f) for f in range(len(rings.F))])
    assert np.array_equal(found, cosines <= MARGIN) and 0 < found.sum() < len(found)


def test_measures_of_a_face(case):
    _, rings, points = case
    for f in range(0, len(rings.F), 17):
        face = rings.F[f]
        a, b, c = points.P[face]
        cross, summed = np.cross(b - a, c - a), points.N[face].sum(0)
        height = np.abs((points.N[face] * ((a + b + c) / 3 - points.P[face])).sum(1)).sum()
        expected = cross @ summed, (cross @ cross) * (summed @ summed), height * np.linalg.norm(cross)
        assert orientation_measures(points.P, points.N, *face) == pytest.approx(expected, rel=1e-9, abs=1e-15)


def test_a_score_that_gives_up_early_says_so_and_else_is_the_whole_one(case):
    H, rings, points = case
    gave_up = 0
    for v in np.flatnonzero(~rings.fixed):
        count, total, height, area = score(rings, points, v, 2, np.inf, np.inf)
        faces = [f for k in range(2) for f in rings.faces[rings.at[k, v]:rings.at[k, v + 1]]]
        cosines = np.array([orientation_cosine(rings.F, points.P, points.N, f) for f in faces])
        assert count == (cosines <= MARGIN).sum() and total == pytest.approx(cosines[cosines <= MARGIN].sum(), abs=1e-9)
        assert score(rings, points, v, 2, count, height) == (count, total, height, area)
        if count:
            assert score(rings, points, v, 2, count - 1, np.inf)[0] == count
            gave_up += 1
        assert score(rings, points, v, 2, np.inf, 0.5 * height)[2] > 0.5 * height or height == 0
    assert gave_up > 3
