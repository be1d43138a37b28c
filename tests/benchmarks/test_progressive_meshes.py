import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.progressive_meshes.mesh import VERTICES, Growing, ring_of, split
from benchmarks.progressive_meshes.simplify import simplify
from benchmarks.progressive_meshes.stream import decode, encode
from npm_blender.core.errors import StreamError
from npm_blender.core.geometry import ClosestPoints, sample
from npm_blender.core.mesh import opposite_halfedges, topology_of, vertex_fans
from tests.meshes.lod_meshes import sheet, sphere, torus, tube

MESHES = {"sphere": sphere(4, 0.002), "torus": torus(noise=0.002), "sheet": sheet(noise=0.002), "tube": tube(noise=0.002)}


@pytest.fixture(scope="module", params=MESHES)
def coded(request):
    mesh = MESHES[request.param]
    collapses = simplify(mesh, 60)
    return mesh, collapses, encode(collapses)


def test_decodes_what_was_encoded(coded):
    mesh, _, encoded = coded
    decoded = decode(encoded.data)
    assert np.array_equal(decoded.F, encoded.mesh.F)
    assert np.array_equal(decoded.V, encoded.mesh.V)
    assert len(decoded.F) == len(mesh.F)
    assert encoded.vertices[-1] == len(mesh.V)


def test_collapses_are_few_enough_and_keep_the_topology(coded):
    mesh, collapses, _ = coded
    assert len(collapses.F) <= 62
    before, after = topology_of(mesh.F), topology_of(np.unique(collapses.F, return_inverse=True)[1].reshape(-1, 3))
    assert (before.euler, before.border_loops) == (after.euler, after.border_loops)


def test_batches_do_not_touch_each_other(coded):
    _, collapses, _ = coded
    for b in np.unique(collapses.batch):
        ends = collapses.ends[collapses.batch == b]
        assert len(np.unique(ends)) == ends.size


def test_every_prefix_past_the_base_is_a_manifold_of_the_same_topology(coded):
    mesh, _, encoded = coded
    want = topology_of(mesh.F)
    faces = []
    for size in np.unique(np.linspace(encoded.base, len(encoded.data), 25).astype(int)):
        F = decode(encoded.data[:size]).F
        found = topology_of(F)
        assert (found.euler, found.border_loops) == (want.euler, want.border_loops)
        assert (vertex_fans(F, opposite_halfedges(F), int(F.max()) + 1) == 1).all()
        faces.append(len(F))
    assert faces == sorted(faces)
    assert faces[0] < 80
    assert faces[-1] == len(mesh.F)


def test_a_prefix_takes_nothing_from_bytes_that_are_missing(coded):
    _, _, encoded = coded
    middle = (encoded.base + len(encoded.data)) // 2
    few, more = decode(encoded.data[:middle]), decode(encoded.data[:middle + 1])
    assert len(few.F) <= len(more.F) <= len(few.F) + 16


def test_distance_falls_with_bytes(coded):
    mesh, _, encoded = coded
    surface = ClosestPoints(mesh)
    sizes = np.geomspace(max(encoded.base, 300), len(encoded.data), 5).astype(int)
    d = [surface.closest(sample(decode(encoded.data[:size]), 5000)[0])[0].mean() for size in sizes]
    assert all(b < 0.95 * a for a, b in zip(d, d[1:], strict=False))
    assert d[-1] < 0.001


def test_less_than_the_base_is_refused(coded):
    _, _, encoded = coded
    for size in (0, 3, encoded.base - 1):
        with pytest.raises(StreamError, match="Expected"):
            decode(encoded.data[:size])


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(["torus", "sheet"]), st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 10**6),
                                                               st.integers(0, 10**6)), min_size=1, max_size=12))
def test_any_splits_leave_a_manifold(name, choices):
    mesh = {"torus": torus(5, 7), "sheet": sheet(5, 7)}[name]
    m = Growing.of(mesh.V, mesh.F, len(choices))
    ring, spoke = np.zeros((2, 400), np.int32)
    for v, a, b in choices:
        v %= int(m.counts[VERTICES])
        count, faces, border = ring_of(m, v, ring, spoke)
        p, q = sorted((a % count, b % count))
        if p == q and not border:
            continue
        split(m, v, ring, spoke, faces, border, -1 if p == q else p, q)
    F = m.faces()
    n = int(m.counts[VERTICES])
    assert (vertex_fans(F, opposite_halfedges(F), n) == 1).all()
    assert np.array_equal(opposite_halfedges(F), m.opposite[:F.size])
    assert np.array_equal(np.bincount(F.reshape(-1), minlength=n), m.valence[:n])
    assert topology_of(F).euler == topology_of(mesh.F).euler
    starts = m.corner[m.out[:n]]
    assert np.array_equal(starts, np.arange(n))
    border = np.unique(F.reshape(-1)[m.opposite[:F.size] == np.arange(F.size)])
    assert (m.opposite[m.out[border]] == m.out[border]).all()
