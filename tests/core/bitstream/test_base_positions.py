import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from npm_blender.core.bitstream.base_positions import MAX_BITS, decode_positions, encode_positions, quantize_positions
from npm_blender.core.bitstream.connectivity import canonical_order, encode_connectivity
from npm_blender.core.errors import MeshError, StreamError
from tests.meshes.base_meshes import TETRAHEDRON, grid, sphere


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
        assert ours <= 0.95 * theirs


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
