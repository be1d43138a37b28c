"""Creases and corners come back, cost little where they are to be expected, and no damage makes anything but others."""
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.bitstream import canonical_order, decode_sharp, encode_sharp, sharp_coding
from npm_blender.core.fitting import sharp_of
from npm_blender.core.mesh import Level, Sharp
from tests.core.bitstream.samples import chosen_sharp, some_sharp
from tests.meshes.base_meshes import TETRAHEDRON, double_torus, grid, punched, sphere
from tests.meshes.dirty_meshes import box

BASES = {"closed": sphere(2)[1], "open": grid(3, 4), "a tube": grid(3, 5, wrap_columns=True), "handles": double_torus(),
         "holes": punched(sphere(3)[1], np.random.default_rng(0), 6), "a tetrahedron": TETRAHEDRON,
         "one face": np.array([[0, 1, 2]]), "two faces": np.array([[0, 1, 2], [0, 3, 1]])}
NAMES = pytest.mark.parametrize("name", BASES)


def case(name, seed=0, spread=1000):
    """A base and lattice positions drawn at random; they lie on top of each other where spread is 1."""
    F0 = canonical_order(BASES[name], int(BASES[name].max()) + 1).F
    level = Level.of(F0, int(F0.max()) + 1)
    return level, np.random.default_rng(seed).integers(0, spread, (level.n, 3))


def same(found, sharp):
    return np.array_equal(found.edges, sharp.edges) and np.array_equal(found.corners, sharp.corners)


@settings(max_examples=60)
@given(st.sampled_from(sorted(BASES)), st.floats(0, 1), st.sampled_from([1, 2, 1000, 1 << 20]), st.integers(0, 2**31))
def test_creases_and_corners_come_back(name, share, spread, seed):
    level, positions = case(name, seed, spread)
    sharp = some_sharp(level, np.random.default_rng(seed), share)
    data = encode_sharp(sharp, positions, level)
    found = decode_sharp(data, positions, level)
    assert same(found, sharp) if data else not (sharp.edges.any() or sharp.corners.any())
    assert found is None or (found.edges.dtype == found.corners.dtype == bool)


@NAMES
def test_nothing_sharp_takes_no_byte(name):
    level, positions = case(name)
    none = chosen_sharp(level, np.zeros(len(level.edges), bool), np.zeros(level.n, bool))
    assert encode_sharp(none, positions, level) == encode_sharp(None, positions, level) == b""
    assert decode_sharp(b"", positions, level) is None


@NAMES
def test_all_that_can_be_sharp_comes_back(name):
    level, positions = case(name)
    for sharp in (chosen_sharp(level, np.full(len(level.edges), edges), np.ones(level.n, bool)) for edges in (True, False)):
        if sharp.edges.any() or sharp.corners.any():
            assert same(decode_sharp(encode_sharp(sharp, positions, level), positions, level), sharp)


def test_only_corners_where_two_lines_meet_are_sent():
    level, positions = case("open")
    sharp = Sharp(np.zeros(len(level.edges), bool), np.ones(level.n, bool))
    border = np.bincount(level.edges[sharp.lines(level)].reshape(-1), minlength=level.n) == 2
    assert np.array_equal(decode_sharp(encode_sharp(sharp, positions, level), positions, level).corners, border)


@settings(max_examples=80)
@given(st.sampled_from(sorted(BASES)), st.binary(min_size=1, max_size=60))
def test_any_bytes_are_some_creases(name, data):
    level, positions = case(name)
    found = decode_sharp(data, positions, level)
    border = level.edge_halfedge[:, 0] == level.edge_halfedge[:, 1]
    assert found.edges.shape == border.shape and found.corners.shape == (level.n,) and not (found.edges & border).any()
    assert same(chosen_sharp(level, found.edges, found.corners), found)


@settings(max_examples=80)
@given(st.data())
def test_any_damage_makes_others(data):
    level, positions = case("holes")
    bad = bytearray(encode_sharp(some_sharp(level, np.random.default_rng(1)), positions, level))
    del bad[data.draw(st.integers(1, len(bad))):]
    for _ in range(data.draw(st.integers(0, 3))):
        bad[data.draw(st.integers(0, len(bad) - 1))] ^= data.draw(st.integers(1, 255))
    found = decode_sharp(bytes(bad), positions, level)
    assert same(chosen_sharp(level, found.edges, found.corners), found)


def test_creases_where_faces_meet_at_an_angle_cost_less_than_any_others():
    mesh = box(4)
    order = canonical_order(mesh.F, len(mesh.V))
    level, positions = Level.of(order.F, len(mesh.V)), np.rint(4096 * mesh.V[order.vertices]).astype(np.int64)
    sharp = sharp_of(positions.astype(float), level, 40)
    others = sharp._replace(edges=np.random.default_rng(0).permutation(sharp.edges))
    sizes = [len(encode_sharp(one, positions, level)) for one in (sharp, others)]
    assert sharp.edges.sum() == 48 and sizes[0] < 0.3 * sizes[1]
    assert same(decode_sharp(encode_sharp(sharp, positions, level), positions, level), sharp)


def test_plain_python_gives_the_same_bytes(monkeypatch):
    level, positions = case("holes")
    sharp = some_sharp(level, np.random.default_rng(1))
    data = encode_sharp(sharp, positions, level)
    for name in ("_code_edges", "_code_corners", "code_bit"):
        monkeypatch.setattr(sharp_coding, name, getattr(getattr(sharp_coding, name), "py_func", getattr(sharp_coding, name)))
    assert encode_sharp(sharp, positions, level) == data and same(decode_sharp(data, positions, level), sharp)
