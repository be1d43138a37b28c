"""Every method that codes gives bytes within the budget and a mesh near the input; the search finds what trying all finds."""

import numpy as np
import pytest

from benchmarks.methods import METHODS, drc, load, qslim, schemes, search, subdivfit
from benchmarks.methods.case import Case
from npm_blender.core.geometry.closest_point import ClosestPoints
from npm_blender.core.mesh import TriMesh
from npm_blender.core.settings import CompressSettings, LodSettings
from tests.few_points import compare_by_few_points
from tests.meshes.shapes import bumpy, grid

CODERS = ("qslim_draco", "meshopt", "draco", "loop", "butterfly", "subdivfit")
BUDGETS = (1_000, 4_000)


def method(name):
    """The module of a method; skips where what it compares with is not installed (requirements/bench.txt)."""
    for needed in {"meshopt": ("meshopt", "zstandard"), "fast_quadric": ("fast_simplification",)}.get(name, ()):
        pytest.importorskip(needed)
    return load(name)


@pytest.fixture(scope="module", autouse=True)
def quick_streams():
    """How near our own are is tested elsewhere."""
    with pytest.MonkeyPatch.context() as patch:
        compare_by_few_points(patch)
        yield


@pytest.fixture(scope="module")
def closed():
    return Case.of("closed", bumpy(4), 10_000)


@pytest.fixture(scope="module")
def case_of(closed):
    """The closed mesh for one of our methods; for displaced surfaces with a base that is soon made."""
    few = Case.of("closed", bumpy(4), 10_000, CompressSettings(LodSettings(base_faces=500, levels=2)))
    return {"ours": few, "ours_paper": closed}


@pytest.fixture(scope="module")
def sheet():
    return Case.of("sheet", grid(40), 10_000)


@pytest.mark.parametrize("name", CODERS)
@pytest.mark.parametrize("shape", ["closed", "sheet"])
def test_bytes_fit_and_more_of_them_are_better(name, shape, request):
    case = request.getfixturevalue(shape)
    small, large = method(name).at_bytes(case, BUDGETS)
    assert large.bytes <= BUDGETS[1] and case.worse(large.mesh) < 100
    if small:  # Draco alone cannot get there
        assert small.bytes <= BUDGETS[0]
        assert case.worse(large.mesh) < case.worse(small.mesh)


def test_ours_with_a_size_makes_a_file_for_each_budget():
    case = Case.of("closed", bumpy(2), 10_000)
    budgets = (300, 380, 500, 10**6, 10**7, 10**8)
    least, small, large, most, same, again = load("ours_sized").at_bytes(case, budgets)
    assert least is None or least.bytes <= 300
    assert small.bytes <= 380 and large.bytes <= 500
    assert case.worse(small.mesh) > case.worse(large.mesh) > case.worse(most.mesh)
    assert most.label == f"{len(case.mesh.F)} faces, 0 levels" and same.bytes == most.bytes and again is same


@pytest.mark.parametrize(("name", "word"), [("ours", "numbers"), ("ours_paper", "latents")])
def test_our_streams_are_cut_and_more_of_them_are_nearer(name, word, case_of):
    case = case_of[name]
    none, *found = load(name).at_bytes(case, (200, 1_500, 3_000, 10**6, 10**7))
    assert none is None and found[2].bytes == found[3].bytes
    assert all(coded.bytes <= budget for coded, budget in zip(found, (1_500, 3_000), strict=False))
    assert all(coded.label.endswith(word) for coded in found)
    errors = [case.worse(coded.mesh) for coded in found]
    assert errors[1] < errors[0] and errors[2] < 1.05 * errors[1] and errors[2] == errors[3]


@pytest.mark.parametrize("name", ["ours", "ours_paper"])
def test_our_streams_know_what_so_many_numbers_buy(name, case_of):
    case = case_of[name]
    few, some, more, none = load(name).at_scalars(case, [600, 2_000, 4_000, 10**7])
    assert few is None and none is None and len(some.F) == len(more.F)
    assert case.worse(more) < case.worse(some)


def test_the_paper_s_tables_are_of_its_model(closed):
    rows = load("ours_paper").extra(closed)
    places = {(about["table"], about["at"]): about for about, _ in rows}
    assert {("features", k) for k in (0, 40, 400, "all")} <= set(places)
    assert {("levels, 400", 1), ("levels, 400", 2), ("levels, all", 1), ("levels, all", 2)} <= set(places)
    for k in (0, 40, 400):
        assert places["features", k]["cr"] == pytest.approx(closed.cr(closed.scalars(k)), rel=0.02)
    assert all(len(mesh.F) == 400 * 4 ** about["level"] for about, mesh in rows)
    assert not hasattr(load("ours"), "extra")


@pytest.mark.parametrize("name", ["qslim", "fast_quadric"])
def test_decimation_keeps_to_the_count_of_numbers(name, closed):
    for count, mesh in zip((600, 1_500), method(name).at_scalars(closed, [600, 1_500]), strict=True):
        assert 0.9 * count <= 3 * len(mesh.V) <= count


@pytest.mark.parametrize("name", ["qslim", "fast_quadric"])
def test_a_count_above_the_inputs_gives_the_input(name, closed):
    assert method(name).at_scalars(closed, [4 * len(closed.mesh.V)])[0] is closed.mesh


def test_a_count_below_what_decimation_reaches_gives_none(closed):
    assert qslim.at_scalars(closed, [6]) == [None]


def test_the_search_is_as_good_as_trying_all(closed):
    best = np.inf
    for bits in range(8, 13):
        for faces in range(200, 1_400, 60):
            data = drc.encode(closed.qslim(faces), bits)
            if len(data) <= 1_500:
                best = min(best, closed.worse(drc.decode(data)))
    found = search.choose(closed, drc.decode, drc.of_qslim(closed, (1_500,)))[0]
    assert closed.worse(found.mesh) < 1.05 * best


def test_a_search_counts_what_a_mesh_leaves_out(closed):
    half = TriMesh(closed.mesh.V, closed.mesh.F[closed.mesh.V[closed.mesh.F].mean(1)[:, 2] > 0])
    assert closed.worse(half) > 500


def test_a_larger_budget_takes_the_better_file_of_a_smaller_one(closed):
    good, poor = (search.Candidate(0, bits, drc.encode(closed.mesh, bits)) for bits in (12, 6))
    small, large = search.choose(closed, drc.decode, [[good], [poor]])
    assert small.mesh is large.mesh and large.bytes == len(good.data)
    assert search.choose(closed, drc.decode, [[], [poor]])[0] is None


def test_a_mesh_that_fits_whole_gets_more_bits(closed):
    found = load("qslim_draco").at_bytes(closed, (1_000_000,))[0]
    assert len(found.mesh.F) == len(closed.mesh.F) and found.label.endswith("14 bits")


@pytest.mark.parametrize("bits", [8, 12])
def test_meshopt_loses_nothing_but_the_rounding(closed, bits):
    meshopt = method("meshopt")
    decoded = meshopt.decode(meshopt.encode(closed.mesh, bits))
    assert len(decoded.F) == len(closed.mesh.F) and len(decoded.V) == len(closed.mesh.V)
    assert ClosestPoints(closed.mesh).closest(decoded.V)[0].max() < 0.5**bits


def test_fitting_halves_the_error_of_loop(closed):
    slim = closed.qslim(300)
    fitted = subdivfit.fit(slim, ClosestPoints(closed.mesh))
    before, after = (closed.worse(schemes.subdivided(mesh, schemes.loop)) for mesh in (slim, fitted))
    assert after < 0.5 * before


def test_every_method_has_a_name_and_something_to_measure():
    names = set()
    for name in METHODS:
        module = method(name)
        names.add(module.NAME)
        assert hasattr(module, "at_bytes") or hasattr(module, "at_scalars")
    assert len(names) == len(METHODS)
