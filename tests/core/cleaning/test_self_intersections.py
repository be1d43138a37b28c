import numpy as np
import pytest

from npm_blender.core.cleaning.self_intersections import SAMPLE, crossing_faces
from tests.meshes.dirty_meshes import (
    box,
    flipped,
    joined,
    moved,
    sphere,
    tetrahedron,
    wave,
)


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
