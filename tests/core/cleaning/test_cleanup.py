import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.cleaning.cleanup import MIN_FACES, clean, inspect
from npm_blender.core.errors import Cancelled, MeshError
from npm_blender.core.mesh.topology import topology_of
from npm_blender.core.mesh.triangle_mesh import TriMesh
from tests.core.cleaning.checks import assert_manifold
from tests.dirty import DIRTY
from tests.meshes.dirty_meshes import (
    box,
    klein,
    mesh,
    more,
    plane,
    soup,
    sphere,
    volume,
)


@pytest.mark.parametrize("name", DIRTY)
def test_dirty_mesh(name):
    make, components, loops, expected_volume, words = DIRTY[name]
    dirty = make()
    result, report = clean(dirty)
    assert_manifold(result)
    counts = topology_of(result.F)
    assert report.after.components == counts.components and report.after.border_loops == counts.border_loops
    assert components in (None, counts.components) and loops in (None, counts.border_loops)
    if expected_volume is not None:
        assert volume(result) == pytest.approx(expected_volume, rel=1e-5, abs=1e-9)
    assert words in report.summary
    assert "\n" not in report.summary and (report.changes == ()) == (words == "")
    if report.changes == ():
        assert result.F is dirty.F and report.summary.startswith("nothing to clean")
    # what is clean stays as it is
    again, second = clean(result)
    assert second.changes == () and (again.F == result.F).all() and (again.V == result.V).all()
    clean(result, "off")
    # no vertex was invented: every vertex lies where one was
    where = {tuple(v) for v in dirty.V.tolist()}
    assert all(tuple(v) in where for v in result.V.tolist())


@pytest.mark.parametrize("name", DIRTY)
def test_off_refuses_exactly_what_does_not_qualify(name):
    dirty = DIRTY[name].make()
    problems = inspect(dirty).problems
    if problems:
        with pytest.raises(MeshError) as caught:
            clean(dirty, "off")
        assert all(p in str(caught.value) for p in problems) and "\n" not in str(caught.value)
    else:
        result, report = clean(dirty, "off")
        assert (result.F == dirty.F).all() and report.changes == ()
        assert_manifold(result)


@pytest.mark.slow
@given(st.integers(0, 2**31), st.integers(5, 40), st.integers(MIN_FACES, 200), st.booleans())
@settings(max_examples=150, deadline=None)
def test_any_triangles_end_in_a_manifold_or_a_named_error(seed, n, m, grid):
    random = np.random.default_rng(seed)
    V = random.integers(0, 3, (n, 3)) if grid else random.normal(size=(n, 3))
    dirty = mesh(V, random.integers(0, n, (m, 3)))
    try:
        result, report = clean(dirty)
    except MeshError as error:
        assert "Expected" in str(error) and "\n" not in str(error)
    else:
        assert_manifold(result)
        assert clean(result, "off")[1].changes == ()
        if len(result.F) >= 2 * MIN_FACES:
            again, second = clean(result)  # may find better pairs among faces as tangled as these, never worse ones
            assert_manifold(again)
            assert second.after.border_edges <= report.after.border_edges


@given(st.integers(0, 2**31))
@settings(max_examples=40, deadline=None)
def test_damage_to_a_good_mesh_is_undone(seed):
    random = np.random.default_rng(seed)
    good = box(4)
    F = good.F[random.permutation(len(good.F))]
    F = np.stack([np.roll(f, random.integers(3)) for f in F])
    F = np.where(random.random((len(F), 1)) < random.random() * 0.5, F[:, ::-1], F)
    V = np.concatenate([good.V, random.normal(size=(5, 3))])
    F = np.concatenate([F, F[random.integers(0, len(F), 4)], [[1, 1, 2]]])
    dirty = mesh(V, F)
    if random.random() < 0.5:
        dirty = soup(dirty)
    result, _ = clean(dirty)
    assert_manifold(result)
    counts = topology_of(result.F)
    assert (counts.euler, counts.components, counts.border_loops) == (2, 1, 0)
    assert len(result.F) == len(good.F) and volume(result) == pytest.approx(1)


def strip(n):
    return mesh([[i // 2, i % 2, 0] for i in range(n + 2)], [[i, i + 1, i + 2][::1 - 2 * (i % 2)] for i in range(n)])


REFUSED = {
    "one triangle": (strip(1), "at least 20 faces, found 1"),
    "two triangles": (strip(2), "at least 20 faces, found 2"),
    "nineteen triangles": (strip(19), "at least 20 faces, found 19"),
    "too small after cleaning": (more(strip(6), F=np.tile(strip(6).F, (5, 1))),
                                 "found 6 after cleaning (dropped 30 duplicate faces)"),
    "only repeated corners": (mesh(np.eye(3), [[0, 0, 1]] * 30), "only faces with repeated corners"),
    "all vertices in one point": (mesh(np.zeros((27, 3)), plane(5).F[:18].repeat(2, 0) % 27), "found"),
    "all vertices in a line": (mesh(plane().V * [1, 0, 0], plane().F), "found"),
    "collinear, all distinct": (mesh(plane().V @ [[1, 0, 0], [0.01, 0, 0], [0, 0, 0]], plane().F), "found"),
}


@pytest.mark.parametrize("name", REFUSED)
@pytest.mark.parametrize("mode", ["auto", "off"])
def test_refused(name, mode):
    bad, words = REFUSED[name]
    with pytest.raises(MeshError) as caught:
        clean(bad, mode)
    assert (words in str(caught.value) or mode == "off") and "\n" not in str(caught.value)


def test_twenty_faces_and_a_flat_grid_are_enough():
    assert clean(strip(20))[1].changes == ()
    assert clean(sphere(0))[1].changes == ()
    assert clean(plane())[1].summary == "nothing to clean; left 1 border open"


@pytest.mark.parametrize("V, F, words", [
    (np.zeros((0, 3)), np.zeros((0, 3), int), "with vertices, found none"),
    (np.eye(3), np.zeros((0, 3), int), "with faces, found none"),
    (np.eye(3) * np.nan, np.array([[0, 1, 2]]), "NaN"),
    (np.eye(3), np.array([[0, 1, 3]]), "found 0..3"),
])
def test_arrays_that_are_no_mesh_are_named(V, F, words):
    with pytest.raises(MeshError, match=words):
        clean(TriMesh(V, F))


def test_the_same_input_gives_the_same_output():
    a, b = clean(klein())[0], clean(klein())[0]
    assert (a.F == b.F).all() and (a.V == b.V).all()


def test_cancelled():
    def cancel(fraction, message):
        raise Cancelled("Cancelled")
    with pytest.raises(Cancelled):
        clean(sphere(), progress=cancel)


def test_progress_rises_to_one_at_most():
    seen = []
    clean(soup(sphere()), progress=lambda fraction, message: seen.append(fraction))
    assert seen == sorted(seen) and 0 <= seen[0] and seen[-1] <= 1 and len(seen) >= 4
