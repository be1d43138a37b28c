import numpy as np

from npm_blender.core.geometry.face_orientation import FLIPPED_SURFACE, is_flipped
from npm_blender.core.geometry.geodesic_trace import move_point, trace_geodesic
from npm_blender.core.untangling.parallel_trials import ParallelTrials

from .test_trial import LEVELS, Flat


def flipped(flat):
    F, P, N = flat.rings.F, flat.points.P, flat.points.N
    return np.array([is_flipped(F, P, N, f, FLIPPED_SURFACE) for f in range(len(F))])


def perturbed(flat, f, trials, covered):
    with ParallelTrials(flat.surface, flat.rings, flat.points, flat.region, trials) as parallel:
        return parallel.try_perturbations(np.array([f]), trials, covered) == 0


def folded(flat):
    """A face of the finest level, flipped by pushing a vertex out of its ring."""
    last = LEVELS - 1
    v = int(np.flatnonzero(np.diff(flat.rings.at[last]) > 0)[-1])
    b = flat.points.b[v].copy()
    step = 1.8 * (flat.points.P[flat.rings.around[flat.rings.at[last, v]]] - flat.points.P[v])
    move_point(flat.surface, flat.points, v, trace_geodesic(flat.surface, flat.points.face[v], b, *step), b)
    faces = np.flatnonzero(flipped(flat))
    return int(faces[faces >= flat.rings.first[last]][0])


def test_a_perturbation_that_fails_leaves_every_bit_as_it_was():
    flat = Flat()
    flat.region.set_work(10_000)
    f = folded(flat)
    before = [x.copy() for x in flat.points]
    assert not perturbed(flat, f, 8, 1e9)  # no try keeps so much of the area
    assert all(np.array_equal(x, y) for x, y in zip(flat.points, before))
    assert 0 < flat.region.work_left < 10_000 and not flat.region.times.moved.any()


def test_a_face_that_is_not_flipped_is_left_alone():
    flat = Flat()
    flat.region.set_work(10_000)
    before = flat.points.P.copy()
    assert not perturbed(flat, int(flat.rings.faces[flat.rings.at[1, flat.v]]), 8, 0.97)
    assert np.array_equal(flat.points.P, before) and flat.region.work_left == 10_000


def test_a_perturbation_that_succeeds_leaves_fewer_flipped_faces_and_notes_what_moved():
    flat = Flat()
    flat.region.set_work(10_000)
    f, before = folded(flat), flipped(flat)
    start = flat.points.P.copy()
    assert perturbed(flat, f, 16, 0.8)
    moved = np.abs(flat.points.P - start).max(1) > 0
    assert flipped(flat).sum() < before.sum() and moved.any() and flat.region.times.moved[moved].all()
