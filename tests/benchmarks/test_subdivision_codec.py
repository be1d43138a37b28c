import numpy as np
import pytest
import scipy.sparse
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.methods import subdivision_codec, subdivision_embedded
from benchmarks.methods.case import Case
from benchmarks.subdivision import search, stream, symbols
from benchmarks.subdivision.descent import Integers, Price, Quadratic, descend
from benchmarks.subdivision.fit import Fit, Target
from benchmarks.subdivision.rates import CLASSES, default_rate
from benchmarks.subdivision.shape import Scheme
from benchmarks.subdivision.stencils import refinement
from npm_blender.core.errors import StreamError
from npm_blender.core.geometry import sample
from npm_blender.core.mesh import Level, TriMesh
from tests.meshes.lod_meshes import sheet, sphere, torus


def wavy(mesh):
    """Waves that a small base misses and two subdivisions can show."""
    V = mesh.V + 0.02 * np.sin(25 * mesh.V[:, [1, 2, 0]] + [0.3, 1.0, 2.0])
    return TriMesh(V, mesh.F)


MESHES = {"sphere": wavy(sphere(4)), "torus": wavy(torus(40, 60)), "sheet": wavy(sheet(41, 61))}


@pytest.fixture(scope="module", params=MESHES)
def based(request):
    mesh = MESHES[request.param]
    target = Target(mesh)
    return mesh, target, search.fitted(mesh, target, 60, 2, 10)


@pytest.fixture(scope="module")
def staged(based):
    return search.staged(based[2], 128, 3000)


def distance(target, mesh):
    return target.surface.closest(sample(mesh, 5000)[0])[0].mean()


@pytest.mark.parametrize("smooth", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("name", MESHES)
def test_subdivision_keeps_planes_and_constants(name, smooth):
    level = Level.of(MESHES[name].F, len(MESHES[name].V))
    S = refinement(level, smooth)
    assert np.allclose(S.sum(1), 1)
    assert S.min() >= 0


def test_loop_masks_of_a_regular_vertex():
    mesh = torus(8, 9)  # every vertex has six neighbours
    level = Level.of(mesh.F, len(mesh.V))
    S = refinement(level, 1.0).toarray()
    assert np.allclose(np.diag(S), 5 / 8)
    assert np.allclose(np.sort(S[0])[-7:-1], 1 / 16)
    assert np.allclose(np.sort(S[-1])[-4:], [1 / 8, 1 / 8, 3 / 8, 3 / 8])


def test_the_border_of_a_subdivided_sheet_depends_on_the_border_only():
    mesh = sheet(5, 6)
    level = Level.of(mesh.F, len(mesh.V))
    border = np.unique(level.edges[level.edge_halfedge[:, 0] == level.edge_halfedge[:, 1]])
    S = refinement(level, 1.0).toarray()
    inside = np.setdiff1d(np.arange(level.n), border)
    assert not S[border][:, inside].any()


def test_a_stream_of_one_stage_decodes_to_what_the_sender_sees(based):
    mesh, target, base = based
    p = search.point(base, 170, None, 3)
    decoded = stream.read(p.data)
    d = p.value * np.repeat(base.settings(170).steps(0), np.diff(base.fit.scheme.first))
    assert np.array_equal(decoded.V, base.fit.scheme.build(base.V0, d)[0])
    assert np.count_nonzero(p.value) > 20


def test_detail_lowers_the_distance_and_a_price_lowers_the_bytes(based):
    mesh, target, base = based
    none = search.point(base, 170, None, 1, trade=1e9)
    assert not none.value.any()
    cheap, dear = search.point(base, 170, None, 3, trade=0.0), search.point(base, 170, None, 3, trade=50.0)
    assert len(dear.data) < 0.95 * len(cheap.data)
    assert cheap.distance < 0.7 * none.distance


def test_the_base_is_fitted(based):
    mesh, target, base = based
    d = np.zeros(int(base.fit.scheme.first[-1]))
    start = base.V0 + np.random.default_rng(0).normal(0, 0.04, base.V0.shape)
    assert base.fit.distance(base.fit.base(start, d), d) < 0.7 * base.fit.distance(start, d)


def test_every_prefix_past_the_base_decodes_and_the_whole_is_exact(based, staged):
    mesh, target, base = based
    whole = stream.read(staged)
    least = len(search.point(base, 128, None, 1, trade=1e9).data)
    distances = []
    for size in np.unique(np.linspace(least, len(staged), 12).astype(int)):
        part = stream.read(staged[:size])
        assert np.array_equal(part.F, whole.F)
        assert np.isfinite(part.V).all()
        distances.append(distance(target, part))
    assert distances[-1] < 0.5 * distances[0]
    assert all(b < 1.15 * a for a, b in zip(distances, distances[1:], strict=False))


def test_less_than_the_base_or_other_data_is_refused(staged):
    for data in (b"", staged[:4], staged[:30], b"\x7f" * 40):
        with pytest.raises(StreamError, match="Expected"):
            stream.read(data)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.floats(0.01, 30.0))
def test_integers_survive_and_prefixes_are_certain(seed, stages, spread):
    mesh = torus(5, 6)
    scheme = Scheme(mesh.F, len(mesh.V), 2, 0.0)
    near, random = symbols.neighbours(scheme.hierarchy), np.random.default_rng(seed)
    n = int(scheme.first[-1])
    table = np.zeros((stages, n), np.int64)
    for s in range(stages):
        table[s] = (2 * table[s - 1] if s else 0) + np.rint(random.laplace(0, spread, n) / (1 + s))
    data = symbols.encode(table, near, scheme.first)
    back, certain = symbols.decode(data, stages, near, scheme.first)
    assert certain == table.size
    assert np.array_equal(back, table)
    cut = len(data) // 2
    part, certain = symbols.decode(data[:cut], stages, near, scheme.first)
    assert np.array_equal(part.reshape(-1)[:certain], table.reshape(-1)[:certain])
    if len(data) > 100:
        assert 0 < certain < table.size


@pytest.fixture
def quadratic():
    """A positive definite A, and the right side of A x = rhs for some x that are no integers."""
    random = np.random.default_rng(0)
    J = random.normal(size=(60, 12))
    A = scipy.sparse.csr_matrix(J.T @ J)
    return A, A @ random.normal(0, 3, 12)


def descended(A, rhs, start, per_bit):
    value = start.copy()
    near = np.full((len(value), 8), -1, np.int32)
    rate = default_rate(0)
    descend(Quadratic.of(A, rhs - A @ start), Integers(value, np.zeros_like(value), near), 0,
            Price(rate.fresh[0], rate.again, per_bit), 50)
    return value


def test_descent_without_a_price_ends_where_no_single_step_helps(quadratic):
    A, rhs = quadratic
    value = descended(A, rhs, np.zeros(12, np.int64), 0.0)
    assert CLASSES == default_rate(0).fresh.shape[1]
    assert (np.abs(rhs - A @ value) <= A.diagonal() / 2 + 1e-9).all()
    assert np.count_nonzero(value) > 6


def test_descent_at_a_high_price_returns_to_the_old_values(quadratic):
    A, rhs = quadratic
    assert not descended(A, rhs, np.full(12, 2), 1e9).any()


def test_neighbours_lie_in_the_faces_at_the_edge():
    mesh = torus(5, 6)
    scheme = Scheme(mesh.F, len(mesh.V), 1, 0.0)
    near = symbols.neighbours(scheme.hierarchy)
    coarse = scheme.hierarchy[0]
    for e in (0, 17, len(coarse.edges) - 1):
        row = near[coarse.n + e]
        faces = coarse.F[(np.isin(coarse.F, coarse.edges[e]).sum(1) == 2)]
        assert set(row[4:6]) | set(row[6:8]) == set(faces.reshape(-1))
        around = {tuple(sorted(p)) for f in faces for p in ((f[0], f[1]), (f[1], f[2]), (f[2], f[0]))}
        assert {tuple(coarse.edges[v - coarse.n]) for v in row[:4]} == around - {tuple(coarse.edges[e])}


def test_samples_see_what_a_vertex_moves():
    mesh = sphere(2)
    scheme = Scheme(mesh.F, len(mesh.V), 2, 1.0)
    fit = Fit(Target(mesh), scheme)
    moved = np.random.default_rng(0).normal(size=(scheme.first[2] - scheme.first[1]))
    N = np.tile([0.0, 0.0, 1.0], (len(moved), 1))
    rows = fit.samples.by_level[1].shape[0]
    want = fit._move(1, 2, moved, N, rows)
    assert np.allclose(fit.samples.by_level[1] @ moved, want[:, 2])


@pytest.mark.slow
def test_methods_stay_within_budgets_and_get_better():
    mesh = wavy(torus(40, 60))
    case = Case("torus", mesh, 5000)
    for method in (subdivision_codec, subdivision_embedded):
        found = method.at_bytes(case, (200, 1000, 2000))
        assert found[0] is None
        assert all(c.bytes <= b for c, b in zip(found[1:], (1000, 2000), strict=True))
        d = [case.original.evaluate(c.mesh).d_pm for c in found[1:]]
        assert d[0] > d[1]
    base = len(subdivision_codec.base(case, *subdivision_codec.FIRST).ints)
    few, none = subdivision_codec.at_scalars(case, [3 * base + 400, 10])
    assert none is None
    assert len(few.F) > 5000
