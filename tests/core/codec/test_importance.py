import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from npm_blender.core.codec import importance
from npm_blender.core.mesh.subdivision import hierarchy
from tests.meshes.shapes import icosphere

LEVELS = hierarchy(icosphere(0).F, 12, 2)


def test_numbers_split_into_level_and_face():
    number = np.arange(20 + 80)
    level, face = importance.split_numbers(number, LEVELS[:-1])
    assert (level == (number >= 20)).all()
    assert (face == np.where(number >= 20, number - 20, number)).all()


@given(st.integers(0, 2**31))
def test_magnitude_order_is_descending_and_leaves_out_zeros(seed):
    random = np.random.default_rng(seed)
    values = random.normal(size=(50, 8)) * (random.random(50) < 0.6)[:, None]
    order = importance.magnitude_order(values)
    norm = np.linalg.norm(values[order], axis=1)
    assert (np.diff(norm) <= 0).all() and (norm > 0).all()
    assert set(order) == set(np.flatnonzero(values.any(1)))


def test_gains_add_up_what_a_level_saves_over_its_face():
    random = np.random.default_rng(0)
    errors = [random.random(320) + k for k in (2.0, 1.0, 0.0)]
    gains = importance.measured_gains(errors, LEVELS[:-1])
    assert gains.shape == (100,)
    assert np.isclose(gains[20:].sum(), (errors[1] - errors[2]).sum())
    own = (errors[0] - errors[1]).reshape(20, 16).sum(1)
    assert (gains[:20] >= own).all()


@given(st.integers(0, 2**31))
def test_parents_come_before_their_best_child(seed):
    random = np.random.default_rng(seed)
    gains = importance.measured_gains([random.normal(size=320) for _ in range(3)], LEVELS[:-1])
    order = importance.gain_order(np.ones((100, 8)), gains)
    place = np.argsort(order)
    best = 20 + np.arange(20) * 4 + gains[20:].reshape(20, 4).argmax(1)
    positive = gains[best] > 0
    assert (place[:20] < place[best])[positive].all()


def some_offsets(seed, share=0.3):
    """Integers on the edges of two levels, most of them zero."""
    random = np.random.default_rng(seed)
    return [random.integers(-3, 4, len(level.edges)) * (random.random(len(level.edges)) < share) for level in LEVELS[:-1]]


@given(st.integers(0, 2**31))
def test_carriers_bring_every_offset_and_each_brings_one(seed):
    random, offsets = np.random.default_rng(seed), some_offsets(seed)
    values = importance.offset_values(offsets, LEVELS[:-1], 8)
    order = random.permutation(np.flatnonzero(values.any(1)))
    kept = importance.carriers(order, offsets, LEVELS[:-1])
    edges = np.concatenate([LEVELS[0].edge_of, LEVELS[1].edge_of + len(LEVELS[0].edges)]).reshape(-1, 3)
    brought = set()
    for number in kept:
        new = set(edges[number][values[number, :3] != 0]) - brought
        assert new
        brought |= new
    assert brought == set(np.flatnonzero(np.concatenate(offsets)))
    assert np.array_equal(kept, order[np.isin(order, kept)])


@given(st.integers(0, 2**31))
def test_an_edge_arrives_with_the_first_of_its_faces(seed):
    order = np.random.default_rng(seed).permutation(100)[:60]
    ranks = importance.edge_ranks(order, LEVELS[:-1])
    place = {int(number): k for k, number in enumerate(order)}
    for first, rank, level in zip((0, 20), ranks, LEVELS[:-1], strict=True):
        for edge in range(len(level.edges)):
            faces = first + level.edge_halfedge[edge] // 3
            assert rank[edge] == min(place.get(int(f), 60) for f in faces)


def test_faces_that_save_most_for_their_bits_come_first():
    offsets = [np.ones(len(level.edges), int) for level in LEVELS[:-1]]
    offsets[0][LEVELS[0].edge_of[:3]] = 100  # as good as the others, and dearer
    saved = [np.full(320, 2.0), np.full(320, 1.0), np.full(320, 0.9)]
    order = importance.offset_order(offsets, saved, LEVELS[:-1])
    place = np.argsort(order)
    assert len(order) == 100 and place[0] > place[1:20].min()
    assert place[20 + 4 * 19:].min() > place[19]    # a face comes before its children


def test_offset_values_are_the_same_on_both_sides_of_an_edge():
    offsets = some_offsets(1)
    values = importance.offset_values(offsets, LEVELS[:-1], 8)
    assert values.shape == (100, 8) and not values[:, 3:].any()
    for first, level in zip((0, 20), LEVELS[:-1], strict=True):
        own = values[first:first + len(level.F), :3].reshape(-1)
        assert np.array_equal(own, own[level.opposite])
