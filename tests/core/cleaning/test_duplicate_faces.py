import numpy as np
import pytest

from npm_blender.core.cleaning.duplicate_faces import doubled_parts, inner_walls
from npm_blender.core.cleaning.edge_groups import EdgeGroups
from npm_blender.core.geometry.welding import near_places
from tests.meshes.dirty_meshes import (
    box,
    flipped,
    glued,
    joined,
    mesh,
    more,
    moved,
    plane,
    shelf,
    sphere,
    without,
)


def groups(m):
    return EdgeGroups.of(m.F, len(m.V))


def test_a_part_that_lies_on_another_is_found_whichever_way_it_looks_and_whatever_it_starts_with():
    m = sphere(1)
    F = np.roll(m.F[::-1], 1, 1)
    doubled = doubled_parts(*_arrays(joined(m, mesh(m.V, F), flipped(m), moved(m, by=(5, 0, 0)))))
    assert (np.flatnonzero(doubled) == np.arange(len(F), 3 * len(F))).all()


def test_parts_that_lie_on_each_other_only_here_and_there_stay():
    assert not doubled_parts(*_arrays(joined(box(), box(at=(1, 0, 0))))).any()
    assert not doubled_parts(*_arrays(joined(sphere(1), more(sphere(1), [[3, 3, 3]], [[*sphere(1).F[0, :2], 42]])))).any()


def _arrays(m):
    return m.V, groups(m)


@pytest.mark.parametrize("m, count", [
    (glued(box(), box(at=(1, 0, 0))), 36),
    (glued(box(), box(at=(1, 0, 0)), box(at=(2, 0, 0))), 72),
    (glued(box(), box(at=(1, 0, 0)), box(at=(0, 1, 0))), 72),  # an L
    (glued(plane(), flipped(plane())), 0),  # a card
    (glued(plane(), plane()), 0),
    (shelf(), 0),
    (glued(box(), mesh(plane(3).V + [0, 0, 1 / 3], plane(3).F)), 0),  # a wall of one sheet: which side is solid?
    (glued(box(), without(box(at=(1, 0, 0)), [100])), 0),  # a hole: the wall can be seen
    (sphere(1), 0),
])
def test_inner_walls(m, count):
    walls = inner_walls(m.F)
    assert walls.sum() == count
    if count:
        sizes = EdgeGroups.of(m.F[~walls], len(m.V)).sizes
        assert (sizes == 2).all()


def test_near_places_keep_to_the_smaller_reach():
    V = np.array([[0, 0, 0], [0.9, 0, 0], [5, 0, 0], [5.9, 0, 0], [0, 0.5, 0]])
    assert near_places(V, np.ones(5)).tolist() == [0, 0, 2, 2, 0]
    assert near_places(V, np.array([1, 1, 1, 0.1, 0.1])).tolist() == [0, 0, 2, 3, 4]


def test_near_places_agree_with_all_pairs():
    random = np.random.default_rng(0)
    V = random.random((400, 3))
    reach = random.uniform(0.02, 0.1, 400)
    near = np.linalg.norm(V[:, None] - V, axis=2) < np.minimum(reach[:, None], reach)
    place = np.arange(400)
    for _ in range(400):
        place = np.where(near, place[None], 400).min(1)
    assert (near_places(V, reach) == place).all()


def test_near_places_end_where_everything_is_near():
    V = np.random.default_rng(0).random((20_000, 3))
    assert len(near_places(V, np.full(20_000, 9.0))) == 20_000
