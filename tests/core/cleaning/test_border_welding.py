import numpy as np
import pytest

from npm_blender.core.cleaning.border_welding import reach_of, weld_borders
from npm_blender.core.cleaning.edge_groups import EdgeGroups
from tests.meshes.dirty_meshes import (
    joined,
    plane,
    soup,
    sphere,
)


def test_a_soup_is_joined_and_surfaces_that_touch_stay_apart():
    m = soup(sphere(1))
    after, merged = weld_borders(m.V, EdgeGroups.of(m.F, len(m.V)))
    assert merged == len(m.V) - len(sphere(1).V) and len(after.border) == 0
    two = joined(sphere(1), sphere(1, at=(2, 0, 0)))
    same = EdgeGroups.of(two.F, len(two.V))
    assert weld_borders(two.V, same) == (same, 0)


def test_the_reach_is_a_share_of_the_box_or_the_rounding_of_single_precision():
    m = plane()
    assert reach_of(m.V + np.pi, m.F) == pytest.approx(1e-6 * np.ptp(m.V, axis=0).max())
    far = (m.V + 1e6).astype(np.float32).astype(float)
    assert reach_of(far, m.F) > 0.1
