import numpy as np
import pytest

from npm_blender.core.cleaning.edge_groups import EdgeGroups
from npm_blender.core.cleaning.manifold_cut import cut
from npm_blender.core.cleaning.orientation import orient
from tests.meshes.dirty_meshes import (
    flipped,
    joined,
    mesh,
    sphere,
)


def groups(m):
    return EdgeGroups.of(m.F, len(m.V))


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
    F, _, _ = orient(m.V, groups(m))
    _, _, opened, _ = cut(m.V, groups(m).replaced(F))
    assert 10 <= opened <= 20


def test_flipped_faces_are_found_and_a_cavity_stays_inward():
    m = sphere(1)
    F = np.where((np.arange(len(m.F)) % 7 == 0)[:, None], m.F[:, ::-1], m.F)
    after, flips, outward = orient(m.V, EdgeGroups.of(F, len(m.V)))
    assert flips == -(-len(m.F) // 7) and outward == 0
    assert (np.sort(after, 1) == np.sort(F, 1)).all() and not EdgeGroups.of(after, len(m.V)).disagree().any()
    hollow = joined(sphere(1, size=2.0), flipped(sphere(1)))
    assert orient(hollow.V, groups(hollow))[0] is hollow.F
    assert orient(flipped(m).V, groups(flipped(m)))[2] == len(m.F)
