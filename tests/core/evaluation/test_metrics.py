import igl
import numpy as np
import pytest

from npm_blender.core.errors import MeshError
from npm_blender.core.evaluation.metrics import Original, compression_ratio, evaluate
from npm_blender.core.mesh.subdivision import Level, midpoints
from npm_blender.core.mesh.triangle_mesh import TriMesh, UnitFrame

N = 40_000


def sphere(levels, bumps=0.0):
    g = (1 + 5**0.5) / 2
    V = np.array([[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g], [0, -1, -g], [0, 1, -g],
                  [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1]])
    F = np.array([[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2],
                  [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5], [2, 4, 11],
                  [6, 2, 10], [8, 6, 7], [9, 8, 1]])
    level = Level.of(F, len(V))
    for _ in range(levels):
        V, level = midpoints(V, level), level.subdivided()
    V = V / np.linalg.norm(V, axis=1, keepdims=True)
    return TriMesh(V * (1 + bumps * np.sin(9 * V[:, :1]) * np.sin(8 * V[:, 1:2])), level.F)


def reference(decoded, original, samples):
    """All measures, with libigl's exact distances and independent random samples."""
    frame = UnitFrame.of(original.V)
    random = np.random.default_rng(99)

    def one_way(a, b):
        area = a.face_areas()
        face = random.choice(len(a.F), samples, p=area / area.sum())
        w = random.dirichlet((1, 1, 1), samples)
        points = np.einsum("nk,nkx->nx", w, frame.to_unit(a.V)[a.F[face]])
        squared, nearest = igl.point_mesh_squared_distance(points, frame.to_unit(b.V), b.F.astype(np.int64))[:2]
        cosine = np.einsum("nx,nx->n", a.face_normals()[face], b.face_normals()[nearest])
        return np.sqrt(squared) * 1e4, np.degrees(np.arccos(cosine.clip(-1, 1))).mean()

    there, d_normal = one_way(decoded, original)
    back, _ = one_way(original, decoded)
    return there.mean(), d_normal, back.mean(), np.sort(there)[int(0.99 * samples)], max(there.max(), back.max())


@pytest.mark.parametrize("scale", [1.0, 250.0])
def test_metrics_agree_with_libigl_to_one_percent(scale):
    original, decoded = sphere(5, 0.1), sphere(3, 0.1)
    move = np.array([1.0, -2.0, 0.5])
    original = TriMesh(original.V * scale + move, original.F)
    decoded = TriMesh(decoded.V * scale + move, decoded.F)
    m = evaluate(decoded, original, 200_000)
    found = (m.d_pm, m.d_normal, m.d_reverse, m.d_p99, m.d_max)
    assert found == pytest.approx(reference(decoded, original, 200_000), rel=0.01)


def test_the_measure_of_searches_is_that_of_the_tables():
    original, decoded = sphere(4, 0.1), sphere(2, 0.1)
    both = Original(original, N)
    assert both.worse(decoded, N) == both.evaluate(decoded).worse
    assert both.worse(decoded, N // 4) == pytest.approx(both.evaluate(decoded).worse, rel=0.02)
    assert both.worse(decoded, N // 4) == Original(original, N // 4).evaluate(decoded).worse


def test_a_spike_shows_in_the_largest_distance_and_a_dent_of_two_percent_in_the_percentile():
    flat = sphere(4)
    spike, dent = flat.V.copy(), flat.V.copy()
    spike[0] *= 1.2
    dent[flat.V[:, 2] > 0.95] *= 0.9  # a cap of 2.5 % of the area
    m = evaluate(TriMesh(spike, flat.F), flat, N)
    assert m.d_p99 < 5 and m.d_max > 500
    assert evaluate(TriMesh(dent, flat.F), flat, N).d_p99 > 400


def test_a_mesh_is_at_no_distance_from_itself():
    m = evaluate(sphere(3, 0.1), sphere(3, 0.1), N)
    assert m.d_pm < 1e-8 and m.d_reverse < 1e-8 and m.d_normal < 0.01


def test_a_plane_moved_by_a_thousandth_is_ten_units_away():
    V = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    F = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    m = evaluate(TriMesh(V + [0, 0, 1e-3], F), TriMesh(V, F), N)
    assert (m.d_pm, m.d_normal, m.d_reverse) == pytest.approx((10, 0, 10), abs=1e-6)


def test_normals_are_oriented():
    V = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    F = np.array([[0, 1, 2]], np.int32)
    assert evaluate(TriMesh(V, F[:, ::-1]), TriMesh(V, F), N).d_normal == pytest.approx(180)


def test_what_is_missing_shows_in_the_reverse_distance_only():
    original = sphere(4)
    half = TriMesh(original.V, original.F[original.V[original.F].mean(1)[:, 2] > 0])
    m = evaluate(half, original, N)
    assert m.d_pm < 1e-6 and m.d_normal < 0.01 and m.d_reverse > 500
    assert m.worse == m.d_reverse


def test_a_part_too_many_counts_like_a_part_that_is_missing():
    whole = sphere(4)
    half = TriMesh(whole.V, whole.F[whole.V[whole.F].mean(1)[:, 2] > 0])
    m = evaluate(whole, half, N)
    assert m.d_reverse < 1e-6 and m.worse == m.d_pm > 500


def test_distances_are_in_the_unit_cube_of_the_original():
    a, b = sphere(4, 0.1), sphere(2, 0.1)
    near = evaluate(b, a, N)
    far = evaluate(TriMesh(b.V * 1024, b.F), TriMesh(a.V * 1024, a.F), N)
    assert (far.d_pm, far.d_normal) == pytest.approx((near.d_pm, near.d_normal), rel=1e-9)


def test_the_same_seed_gives_the_same_figures_and_another_nearly():
    a, b = sphere(4, 0.1), sphere(2, 0.1)
    assert evaluate(b, a, N) == evaluate(b, a, N) == Original(a, N).evaluate(b)
    other = evaluate(b, a, N, seed=1)
    assert evaluate(b, a, N).d_pm == pytest.approx(other.d_pm, rel=0.02) and evaluate(b, a, N) != other


def test_faces_without_area_change_nothing():
    a, b = sphere(4, 0.1), sphere(2, 0.1)
    dirty = TriMesh(a.V, np.concatenate([a.F, [[0, 0, 1], [5, 5, 5]]]).astype(np.int32))
    assert evaluate(b, dirty, N) == evaluate(b, a, N)


@pytest.mark.parametrize("which", ["decoded mesh", "original"])
def test_a_mesh_without_area_is_refused_by_name(which):
    good, flat = sphere(1), TriMesh(np.eye(3), np.array([[0, 0, 1]], np.int32))
    with pytest.raises(MeshError, match=f"Expected the {which} to have a surface"):
        evaluate(*((flat, good) if which == "decoded mesh" else (good, flat)), N)


def test_a_search_refuses_a_mesh_without_area():
    with pytest.raises(MeshError, match="Expected the decoded mesh to have a surface"):
        Original(sphere(1), N).worse(TriMesh(np.eye(3), np.array([[0, 0, 1]], np.int32)), N)


def test_compression_ratio_is_the_papers_formula():
    assert compression_ratio(50_000, 202, 0) == pytest.approx(150_000 / 606)
    assert compression_ratio(50_000, 202, 40 * 8) == pytest.approx(150_000 / (606 + 320))
    assert compression_ratio(50_000, 202, 400 * 4) == pytest.approx(150_000 / (606 + 1600))
