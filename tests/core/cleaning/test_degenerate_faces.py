import numpy as np
import pytest

from npm_blender.core.cleaning.degenerate_faces import (
    FLAT,
    collapse_zero_edges,
    flatness,
    remove_flat_faces,
    repeated_corners,
)
from npm_blender.core.cleaning.edge_groups import EdgeGroups
from npm_blender.core.mesh.topology import topology_of
from tests.core.cleaning.checks import assert_manifold
from tests.meshes.dirty_meshes import (
    box,
    mesh,
    sphere,
    volume,
    with_cap,
)


def test_flat_faces_leave_no_gap_and_move_nothing():
    m = box(3)
    for _ in range(6):
        m = with_cap(m)
    F, mended, kept = remove_flat_faces(m.V, m.F)
    assert (flatness(m.V, F) > FLAT).all() and (mended, kept) == (6, 0) and len(F) == len(m.F)
    assert_manifold(mesh(m.V, F))
    assert volume(mesh(m.V, F)) == pytest.approx(1) and topology_of(F).euler == 2


def test_flatness_is_twice_the_area_over_the_squared_longest_edge():
    V = np.array([[0, 0, 0], [4, 0, 0], [1, 1, 0], [2, 0, 0]], float)
    F = np.array([[0, 1, 2], [0, 1, 3], [0, 0, 0]], np.int32)
    assert flatness(V, F).tolist() == [0.25, 0, 0]
    assert repeated_corners(F).tolist() == [False, False, True]


def test_edges_of_zero_length_are_collapsed():
    m = sphere(1)
    V = m.V.copy()
    V[m.F[0, 1]] = V[m.F[0, 0]]
    F, merged = collapse_zero_edges(V, EdgeGroups.of(m.F, len(V)))
    assert merged == 1 and repeated_corners(F).sum() == 2
    assert collapse_zero_edges(m.V, EdgeGroups.of(m.F, len(m.V)))[0] is m.F
