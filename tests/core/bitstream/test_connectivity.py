import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from npm_blender.core.bitstream.connectivity import (
    MAX_FACES,
    canonical_order,
    decode_connectivity,
    encode_connectivity,
    order_connectivity,
)
from npm_blender.core.bitstream.varint import write_varint
from npm_blender.core.errors import MeshError, StreamError
from npm_blender.core.mesh.topology import topology_of
from tests.meshes.base_meshes import TETRAHEDRON, compact, double_torus, grid, punched, shuffled, sphere

MESHES = {
    "tetrahedron": TETRAHEDRON,
    "one triangle": np.array([[0, 1, 2]]),
    "strip": grid(1, 9),
    "disc": grid(6, 8),
    "tube": grid(5, 7, wrap_columns=True),
    "torus": grid(6, 7, True, True),
    "small torus": grid(3, 3, True, True),
    "double torus": double_torus(),
    "sphere": sphere(5)[1],
    "two spheres and a disc": np.concatenate([TETRAHEDRON, TETRAHEDRON + 4, grid(3, 3) + 8]),
}


def check(F):
    F = np.asarray(F)
    n = int(F.max()) + 1
    order = canonical_order(F, n)
    assert sorted(order.vertices) == list(range(n)) and sorted(order.faces) == list(range(len(F)))
    old = F[order.faces]
    new = order.vertices[order.F]
    turned = [(np.roll(old, -k, 1) == new).all(1) for k in range(3)]
    assert np.any(turned, 0).all()      # rotated at most, never mirrored
    data = encode_connectivity(order.F)
    back = decode_connectivity(data)
    assert back.dtype == np.int32 and np.array_equal(back, order.F)
    assert order_connectivity(F, n).data == data
    again = canonical_order(order.F, n)
    assert np.array_equal(again.F, order.F) and (again.vertices == np.arange(n)).all()
    return data


@pytest.mark.parametrize("name", MESHES)
def test_every_topology_comes_back(name):
    check(MESHES[name])


def test_topology_is_what_the_names_say():
    assert topology_of(MESHES["double torus"]).genus == 2 and topology_of(MESHES["torus"]).genus == 1
    assert topology_of(MESHES["tube"]).border_loops == 2 and topology_of(MESHES["two spheres and a disc"]).components == 3


@settings(deadline=None, max_examples=80)
@given(st.sampled_from(sorted(MESHES)), st.integers(0, 2**32 - 1), st.integers(0, 25))
def test_any_order_and_any_holes_come_back(name, seed, holes):
    rng = np.random.default_rng(seed)
    check(shuffled(punched(MESHES[name], rng, holes), rng))


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 2**32 - 1), st.integers(4, 150))
def test_any_degrees_come_back(seed, points):
    rng = np.random.default_rng(seed)
    F = compact(Delaunay(rng.random((points, 2)) ** [1, 3]).simplices)
    check(shuffled(F, rng))


def test_irregular_mesh_costs_at_most_two_bits_per_face():
    rng = np.random.default_rng(1)
    faces = bits = 0
    for _ in range(5):
        F = compact(Delaunay(rng.random((210, 2))).simplices)
        faces, bits = faces + len(F), bits + 8 * len(check(F))
    assert bits / faces <= 2.0


def test_regular_mesh_costs_almost_nothing():
    assert len(check(grid(40, 40, True, True))) < 120       # 3200 faces


@pytest.mark.parametrize("F, n, words", [
    (TETRAHEDRON, 5, "isolated"),
    ([[0, 1, 2], [0, 3, 4]], 5, "touch in a point"),
    ([[0, 1, 2], [0, 1, 3]], 4, "oriented manifold"),
    ([[0, 1, 2], [0, 2, 1]], 3, "collapsed"),
    (np.zeros((0, 3), int), 0, "1 to"),
])
def test_what_is_no_manifold_is_refused(F, n, words):
    with pytest.raises(MeshError, match=words):
        canonical_order(np.array(F), n)


def test_another_order_is_refused():
    with pytest.raises(MeshError, match="canonical"):
        encode_connectivity(shuffled(MESHES["torus"], np.random.default_rng(0)))


@pytest.mark.parametrize("data", [b"", b"\x05", write_varint(MAX_FACES + 1) + b"\0", b"\0\0", write_varint(10**15) + b"\0",
                                  b"\x04\x09"])
def test_absurd_counts_are_refused(data):
    with pytest.raises(StreamError):
        decode_connectivity(data)


@settings(deadline=None, max_examples=300)
@given(st.integers(1, 60), st.integers(0, 3), st.binary(max_size=40))
def test_any_bytes_give_a_manifold_or_an_error(faces, borders, bits):
    try:
        F = decode_connectivity(write_varint(faces) + write_varint(borders) + bits)
    except StreamError:
        return
    assert F.shape == (faces, 3) and topology_of(F).faces == faces


@pytest.mark.parametrize("borders", [0, 2, 1000])
@pytest.mark.parametrize("bits", [b"", b"\xff" * 40, bytes(range(256))])
def test_a_promise_of_many_faces_ends_soon(borders, bits):
    """Whatever the bytes, the time grows with the faces that they promise, not with their square."""
    begun = time.process_time()
    try:
        decode_connectivity(write_varint(MAX_FACES) + write_varint(borders) + bits)
    except StreamError:
        pass
    assert time.process_time() - begun < 20     # a second of it compiled; the rest is for the compilation


@settings(deadline=None, max_examples=60)
@given(st.sampled_from(sorted(MESHES)), st.data())
def test_prefixes_give_a_manifold_or_an_error(name, data):
    F = canonical_order(np.asarray(MESHES[name]), int(np.max(MESHES[name])) + 1).F
    whole = encode_connectivity(F)
    try:
        back = decode_connectivity(whole[:data.draw(st.integers(0, len(whole)))])
    except StreamError:
        return
    assert topology_of(back).faces == len(F)
