import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from npm_blender.core.mesh.spatial_order import BITS, along_curve, in_morton_order, morton_keys, spatial_boxes
from npm_blender.core.mesh.triangle_mesh import TriMesh
from tests.meshes.lod_meshes import torus


def soup(mesh):
    """Faces as sets of corners, in an order that no numbering changes."""
    return sorted(map(tuple, mesh.V[mesh.F].reshape(-1, 9).tolist()))


@given(st.integers(0, 2**32 - 1))
def test_the_mesh_stays_the_same_whatever_its_numbering(seed):
    mesh, random = torus(8, 12), np.random.default_rng(seed)
    p = random.permutation(len(mesh.V))
    F = np.argsort(p).astype(np.int32)[mesh.F][random.permutation(len(mesh.F))]
    ordered = in_morton_order(TriMesh(mesh.V[p], F))
    assert soup(ordered) == soup(mesh)
    assert np.array_equal(np.sort(ordered.V, axis=0), np.sort(mesh.V, axis=0))


def test_neighbours_are_near_in_memory():
    mesh, random = torus(60, 90), np.random.default_rng(0)
    p = random.permutation(len(mesh.V))
    mixed = TriMesh(mesh.V[p], np.argsort(p).astype(np.int32)[mesh.F])
    ordered = in_morton_order(mixed)
    gap = [np.median(np.ptp(m.F.astype(int), axis=1)) for m in (mixed, ordered)]
    assert gap[1] < 0.05 * gap[0]


def test_points_in_one_place_and_no_points_at_all():
    one = TriMesh(np.ones((3, 3)), np.array([[0, 1, 2]], np.int32))
    assert np.array_equal(in_morton_order(one).F, one.F)
    none = TriMesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    assert len(in_morton_order(none).V) == 0


@given(st.integers(1, 400), st.integers(1, 60), st.integers(0, 2**32 - 1))
def test_boxes_are_full_enough_and_no_fuller_than_asked(n, most, seed):
    box = spatial_boxes(np.random.default_rng(seed).random((n, 3)), most)
    sizes = np.bincount(box)
    assert sizes.max() <= most and (sizes.min() >= most // 2 or len(sizes) == 1)
    assert sizes.sum() == n and (sizes > 0).all()


def test_boxes_do_not_overlap():
    P = np.random.default_rng(1).random((1000, 3))
    box = spatial_boxes(P, 100)
    low, high = (np.array([f(P[box == k], axis=0) for k in range(box.max() + 1)]) for f in (np.min, np.max))
    overlap = (low[:, None] < high[None]).all(2) & (low[None] < high[:, None]).all(2)
    assert overlap.sum() == len(low)


def test_points_in_one_place_are_divided_too():
    assert np.bincount(spatial_boxes(np.zeros((100, 3)), 30)).max() <= 30


@given(st.lists(st.tuples(*[st.integers(0, 2**BITS - 1)] * 3), min_size=1, max_size=20))
def test_keys_interleave_the_bits_of_the_coordinates(cells):
    keys = morton_keys(*np.array(cells, np.uint32).T)
    assert keys.dtype == np.uint32
    for key, cell in zip(keys.tolist(), cells, strict=True):
        assert key == sum((c >> i & 1) << 3 * i + axis for axis, c in enumerate(cell) for i in range(BITS))


def test_points_along_the_curve_are_near_each_other():
    P = np.random.default_rng(2).random((2000, 3))
    order = along_curve(P)
    assert np.array_equal(np.sort(order), np.arange(2000))
    steps = np.linalg.norm(np.diff(P[order], axis=0), axis=1)
    assert np.median(steps) < 0.2 * np.median(np.linalg.norm(np.diff(P, axis=0), axis=1))
