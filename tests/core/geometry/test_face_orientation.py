import numpy as np
import pytest

from npm_blender.core.geometry.face_orientation import (
    FLIPPED_FIT,
    FLIPPED_SURFACE,
    OPPOSED,
    is_flipped,
    is_flipped_from,
    not_flipped,
    orientation_cosine,
    orientation_measures,
)

THRESHOLDS = (OPPOSED, FLIPPED_SURFACE, FLIPPED_FIT)


@pytest.fixture
def soup():
    """Faces without common corners, at random, and unit normals of a surface at their corners."""
    random = np.random.default_rng(3)
    P, N = random.normal(size=(2, 600, 3))
    return np.arange(600, dtype=np.int32).reshape(-1, 3), P, N / np.linalg.norm(N, axis=1, keepdims=True)


def normals(F, P):
    a, b, c = P[F].swapaxes(0, 1)
    return np.cross(b - a, c - a)


def test_the_thresholds_get_milder_the_less_moves_afterwards():
    assert 0 == OPPOSED < FLIPPED_SURFACE < FLIPPED_FIT < 1


@pytest.mark.parametrize("threshold", THRESHOLDS)
def test_a_face_is_flipped_where_its_cosine_is_at_most_the_threshold(soup, threshold):
    F, P, N = soup
    n, s = normals(F, P), N[F].sum(1)
    cosines = (n * s).sum(1) / np.linalg.norm(n, axis=1) / np.linalg.norm(s, axis=1)
    found = np.array([is_flipped(F, P, N, f, threshold) for f in range(len(F))])
    assert np.array_equal(found, cosines <= threshold) and 0 < found.sum() < len(found)


@pytest.mark.parametrize("threshold", THRESHOLDS)
def test_against_one_normal_a_face_is_flipped_where_the_cosine_is_below_the_threshold(soup, threshold):
    F, P, N = soup
    n = normals(F, P)
    cosines = (n * N[:len(F)]).sum(1) / np.linalg.norm(n, axis=1)
    found = np.array([is_flipped_from(F, P, N[:len(F)], f, threshold) for f in range(len(F))])
    assert np.array_equal(found, cosines < threshold) and 0 < found.sum() < len(found)


def test_faces_without_area_are_flipped_on_the_surface_and_not_in_the_fit():
    F, P, N = np.array([[0, 1, 1]], np.int32), np.eye(3), np.eye(3)
    assert all(is_flipped(F, P, N, 0, threshold) and not is_flipped_from(F, P, N, 0, threshold) for threshold in THRESHOLDS)
    assert not not_flipped(0.0, 0.0, OPPOSED) and orientation_cosine(0.0, 0.0) == 0


def test_measures_of_a_face(soup):
    F, P, N = soup
    for f, n in zip(F, normals(F, P), strict=True):
        summed = N[f].sum(0)
        height = np.abs((N[f] * (P[f].mean(0) - P[f])).sum(1)).sum()
        product, size, bulge = orientation_measures(P, N, *f)
        assert (product, size) == pytest.approx((n @ summed, (n @ n) * (summed @ summed)), rel=1e-9, abs=1e-15)
        assert bulge == pytest.approx(height * np.linalg.norm(n), rel=1e-9)
        assert not_flipped(product, size, FLIPPED_SURFACE) == (orientation_cosine(product, size) > FLIPPED_SURFACE)
