import numpy as np
import pytest

from npm_blender.core.cleaning.cleanup import clean
from npm_blender.core.cleaning.duplicate_faces import doubled_parts, inner_walls
from npm_blender.core.cleaning.edge_groups import EdgeGroups
from npm_blender.core.cleaning.manifold_cut import cut
from npm_blender.core.cleaning.orientation import orient
from npm_blender.core.cleaning.self_intersections import SAMPLE, crossing_faces
from npm_blender.core.cleaning.t_junctions import split_at_junctions
from npm_blender.core.geometry.closest_point import ClosestPoints
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
    tetrahedron,
    unequal_sides,
    wave,
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
    return m.V, m.F, groups(m)


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


def test_both_sides_of_a_crack_get_the_vertices_of_the_other():
    m = unequal_sides()
    F, splits = split_at_junctions(m.V, m.F, groups(m), 1e-9)
    assert splits == 16 and (EdgeGroups.of(F, len(m.V)).sizes == 2).all()
    distance, _, _ = ClosestPoints(m).closest(m.V[F].mean(1))
    assert distance.max() < 1e-12 and mesh(m.V, F).face_areas().sum() == pytest.approx(6)


def test_offset_rows_are_split_on_both_sides():
    """Two strips along the x axis, one with vertices at sixths of it, one at quarters."""
    def strip(n, y):
        x = np.arange(n + 1) / n
        V = np.concatenate([np.column_stack([x, 0 * x, 0 * x]), np.column_stack([x, 0 * x + y, 0 * x])])
        i = np.arange(n)
        F = np.concatenate([np.stack([i, i + 1, i + n + 2], 1), np.stack([i, i + n + 2, i + n + 1], 1)])
        return mesh(V, F if y > 0 else F[:, ::-1])
    m = glued(strip(6, 1), strip(4, -1))
    F, splits = split_at_junctions(m.V, m.F, groups(m), 1e-6)
    assert splits == 2 + 4  # sixths that are no quarters, quarters that are no sixths, with one of each in the middle
    border = groups(mesh(m.V, F))
    alone = border.halfedges[border.starts[:-1][border.sizes == 1]]
    y = m.V[F.reshape(-1)[alone], 1] + m.V[np.roll(F, -1, 1).reshape(-1)[alone], 1]
    assert (y != 0).all()  # no border is left on the axis
    cleaned, report = clean(m)
    assert report.after.components == 1 and report.after.border_loops == 1 and "T-junctions" in report.summary


def test_a_vertex_beside_an_edge_does_not_split_it():
    m = unequal_sides()
    V = m.V.copy()
    V[(V[:, 2] == 1) & (np.abs(V[:, 0] - 0.125) < 1e-9) & (V[:, 1] == 0), 1] = -1e-3
    F, splits = split_at_junctions(V, m.F, groups(m), 1e-6)
    assert splits == 15


def test_many_vertices_on_one_edge():
    n = 200
    fan = mesh([[0, 0, 0], [1, 0, 0], [0.5, -1, 0]], [[1, 0, 2]])
    t = np.arange(n + 1) / n
    V = np.concatenate([np.column_stack([t, 0 * t, 0 * t]), [[0.5, 1, 0]]])
    comb = mesh(V, [[i, i + 1, n + 1] for i in range(n)])
    m = glued(fan, comb)
    cleaned, report = clean(m)
    assert f"closed {n - 1} T-junctions" in report.summary and report.after.border_edges == 4
    assert cleaned.face_areas().sum() == pytest.approx(1)


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


@pytest.mark.parametrize("m, count", [
    (sphere(3), 0),
    (box(8), 0),
    (joined(box(), box(at=(1, 0, 0))), 0),  # touch in a plane
    (joined(sphere(3), sphere(size=0.5)), 0),  # one inside the other
    (wave(20), 0),
    (joined(moved(tetrahedron(), 1.0), moved(flipped(tetrahedron()), -1.0, (0.1, 0.05, 0.02))), 8),
])
def test_faces_that_pass_through_others(m, count):
    assert crossing_faces(m.V, m.F) == (count, True)


@pytest.mark.parametrize("scale", [1e-20, 1.0, 1e12])
def test_spheres_through_each_other_cross_along_a_circle(scale):
    m = moved(joined(sphere(3), sphere(3, at=(0.7, 0.01, 0))), scale)
    count, exact = crossing_faces(m.V, m.F)
    centre = m.V[m.F].mean(1) / scale
    seam = np.abs(np.linalg.norm(centre, axis=1) - np.linalg.norm(centre - [0.7, 0.01, 0], axis=1)) < 0.02
    assert exact and seam.sum() < count < 400


def test_a_sample_of_many_faces_gives_about_their_number():
    m = joined(sphere(5), sphere(5, at=(0.7, 0.01, 0)))
    assert len(m.F) > SAMPLE
    count, exact = crossing_faces(m.V, m.F)
    one, other = m.F[:len(m.F) // 2], m.F[len(m.F) // 2:]
    assert not exact and crossing_faces(m.V, one)[0] == 0 and crossing_faces(m.V, other)[0] == 0
    small = joined(sphere(3), sphere(3, at=(0.7, 0.01, 0)))
    assert count == pytest.approx(4 * crossing_faces(small.V, small.F)[0], rel=0.3)  # a curve: twice a level


def test_faces_piled_on_each_other_are_given_up():
    random = np.random.default_rng(0)
    V = random.normal(size=(60_000, 3))
    count, exact = crossing_faces(V, np.arange(60_000).reshape(-1, 3))
    assert count > 10_000


def band(n, k, seed):
    """A Moebius band, k quads across, in random order with faces turned at random."""
    t, u = np.arange(n) * np.pi / n, np.linspace(-0.3, 0.3, k + 1)
    V = np.array([[(1 + s * np.cos(x)) * np.cos(2 * x), (1 + s * np.cos(x)) * np.sin(2 * x), s * np.sin(x)]
                  for x in t for s in u])
    at = lambda i, j: i * (k + 1) + j if i < n else k - j
    F = np.array([f for i in range(n) for j in range(k) for f in (
        [at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)])])
    random = np.random.default_rng(seed)
    F = F[random.permutation(len(F))]
    return mesh(V, np.where(random.random((len(F), 1)) < 0.5, F[:, ::-1], F))


@pytest.mark.parametrize("seed", range(4))
def test_a_one_sided_band_is_cut_across_not_along(seed):
    m = band(60, 10, seed)
    F, _, _ = orient(m.V, m.F, groups(m))
    _, _, opened, _ = cut(m.V, F, EdgeGroups.of(F, len(m.V)))
    assert 10 <= opened <= 20


def test_a_face_is_not_split_at_its_own_corner():
    flat = mesh([[0, 0, 0], [2, 0, 0], [1, 0, 0], [0, -1, 0], [2, -1, 0]], [[0, 1, 2], [0, 3, 2], [2, 4, 1]])
    F, splits = split_at_junctions(flat.V, flat.F, groups(flat), 1e-6)
    assert splits == 0 and F is flat.F
