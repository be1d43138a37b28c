import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from npm_blender.core.bitstream.base_positions import decode_positions, encode_positions, quantize_positions
from npm_blender.core.bitstream.connectivity import canonical_order, encode_connectivity
from npm_blender.core.bitstream.header import MAX_BITS
from npm_blender.core.errors import MeshError, StreamError
from tests.meshes.base_meshes import TETRAHEDRON, double_torus, grid, punched, sphere


def test_quantized_positions_are_the_nearest_of_the_lattice():
    V, _ = sphere(6)
    ints, Vq = quantize_positions(V, 10)
    assert ints.dtype == np.int64 and np.abs(Vq - V).max() <= 2.0**-11 and np.array_equal(Vq * 1024, ints)


@settings(deadline=None, max_examples=60)
@given(arrays(np.int64, (4, 3), elements=st.integers(-(2**21), 2**21)))
def test_any_positions_come_back(ints):
    F = canonical_order(TETRAHEDRON, 4).F
    assert np.array_equal(decode_positions(encode_positions(ints, F), F), ints)


@pytest.mark.parametrize("bits", [4, 9, 12, 14, MAX_BITS])
@pytest.mark.parametrize("open_border", [False, True])
def test_meshes_come_back(bits, open_border):
    V, F = (np.random.default_rng(0).random((63, 3)), grid(6, 8)) if open_border else sphere(6)
    order = canonical_order(F, len(V))
    ints, _ = quantize_positions(V[order.vertices], bits)
    data = encode_positions(ints, order.F)
    assert np.array_equal(decode_positions(data, order.F), ints)
    assert 8 * len(data) < ints.size * (bits + 4)


def test_base_is_smaller_than_draco():
    draco = pytest.importorskip("DracoPy")
    igl = pytest.importorskip("igl")
    V, F = sphere(40)
    rng = np.random.default_rng(0)
    V = V * (1 + 0.15 * np.sin(5 * V[:, :1] * 6) * np.cos(4 * V[:, 1:2] * 6)) + 0.002 * rng.standard_normal(V.shape)
    result = [a for a in igl.qslim(V, F, 400) if isinstance(a, np.ndarray)]
    V, F = result[0], result[1]
    low, high = V.min(0), V.max(0)
    V = (V - (low + high) / 2) / (high - low).max()
    order = canonical_order(F, len(V))
    for bits in (10, 12):
        ours = len(encode_connectivity(order.F)) + len(encode_positions(quantize_positions(V[order.vertices], bits)[0], order.F))
        theirs = len(draco.encode(V, F, quantization_bits=bits, compression_level=10))
        assert ours <= 0.9 * theirs


@pytest.mark.parametrize("bad", [np.nan, np.inf, 4.0, -1e9])
def test_coordinates_out_of_range_are_refused(bad):
    with pytest.raises(MeshError, match="unit frame"):
        quantize_positions(np.array([[0, 0, bad]]), 12)


def test_integers_out_of_range_are_refused():
    with pytest.raises(MeshError, match="lattice"):
        encode_positions(np.full((4, 3), 2**22), canonical_order(TETRAHEDRON, 4).F)


@settings(deadline=None, max_examples=100)
@given(st.binary(max_size=200))
def test_any_bytes_give_bounded_positions_or_an_error(data):
    F = canonical_order(grid(6, 8), 63).F
    try:
        assert (np.abs(decode_positions(data, F)) < 2**22).all()
    except StreamError as e:
        assert "corrupted" in str(e)


@settings(deadline=None, max_examples=60)
@given(st.sampled_from(["torus", "tube", "double torus", "parts", "holes"]), st.sampled_from([0, 3, 10, 20]),
       st.integers(0, 2**32 - 1))
def test_any_positions_on_any_topology_come_back(name, bits, seed):
    rng = np.random.default_rng(seed)
    F = {"torus": grid(6, 7, True, True), "tube": grid(5, 7, wrap_columns=True), "double torus": double_torus(),
         "parts": np.concatenate([TETRAHEDRON, grid(3, 3) + 4]), "holes": punched(sphere(4)[1], rng, 9)}[name]
    F = np.unique(F, return_inverse=True)[1].reshape(-1, 3)
    F = canonical_order(F, int(F.max()) + 1).F
    ints = rng.integers(-(2**bits), 2**bits + 1, (F.max() + 1, 3))
    assert np.array_equal(decode_positions(encode_positions(ints, F), F), ints)


def test_extreme_positions_come_back():
    F = canonical_order(grid(6, 8), 63).F
    ints = np.where(np.random.default_rng(1).random((63, 3)) < 0.5, 2**22 - 1, 1 - 2**22)
    assert np.array_equal(decode_positions(encode_positions(ints, F), F), ints)


def test_a_plane_of_regular_rows_costs_almost_nothing():
    F = grid(40, 40)
    order = canonical_order(F, 41 * 41)
    rows, columns = np.divmod(order.vertices.astype(np.int64), 41)
    ints = np.stack([20 * rows + 3 * columns, 17 * columns, 0 * rows], 1)
    assert 8 * len(encode_positions(ints, order.F)) < 0.6 * len(ints)


def test_errors_lie_flat_and_cost_less_along_the_normal():
    """Vertices moved about in a tilted plane cost at least three bits less than those moved out of it as well."""
    order = canonical_order(grid(40, 40), 41 * 41)
    rows, columns = np.divmod(order.vertices.astype(np.int64), 41)
    rng = np.random.default_rng(0)
    tilt = np.array([[3, 1, 2], [-1, 3, 0]])  # a plane along no axis
    flat = (np.stack([rows, columns], 1) * 40 + rng.integers(-9, 10, (41 * 41, 2))) @ tilt
    bits = 8 * len(encode_positions(flat, order.F)) / len(flat)
    apart = flat + rng.integers(-30, 31, flat.shape)
    assert bits < 8 * len(encode_positions(apart, order.F)) / len(flat) - 3


@pytest.mark.slow
def test_plain_python_writes_the_same_bytes():
    code = ("import numpy as np\n"
            "from npm_blender.core.bitstream import canonical_order, decode_positions, encode_connectivity, encode_positions\n"
            "from tests.meshes.base_meshes import grid\n"
            "F = canonical_order(grid(5, 6, True, False), 35).F\n"
            "ints = np.arange(105).reshape(-1, 3) ** 3 % 1009\n"
            "data = encode_positions(ints, F)\n"
            "assert np.array_equal(decode_positions(data, F), ints)\n"
            "print(encode_connectivity(F).hex(), data.hex())\n")
    command = [sys.executable, "-W", "error::RuntimeWarning", "-c", code]
    said = [subprocess.run(command, capture_output=True, text=True, check=True, env=os.environ | more).stdout
            for more in ({}, {"NUMBA_DISABLE_JIT": "1"})]
    assert said[0] == said[1]
