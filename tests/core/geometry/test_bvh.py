import numpy as np
import pytest

from npm_blender.core.geometry.bvh import BVH_STACK, LEAF, build_bvh


def corners(kind, m=3000):
    random = np.random.default_rng(2)
    centre = {"spread": random.random((m, 1, 3)), "on a line": random.random((m, 1, 1)) * [1, 0, 0],
              "one place": np.zeros((m, 1, 3)), "far apart": 10.0 ** random.integers(-9, 9, (m, 1, 1)) * [1, 1, 1]}[kind]
    return (centre + 0.01 * random.normal(size=(m, 3, 3)) * (kind != "one place")).reshape(m, 9)


@pytest.mark.parametrize("kind", ["spread", "on a line", "one place", "far apart"])
def test_every_triangle_is_in_one_leaf_and_every_box_holds_what_is_below_it(kind):
    triangles = corners(kind)
    boxes, links, order = build_bvh(triangles)
    assert np.array_equal(np.sort(order), np.arange(len(triangles)))
    rows, seen, todo, deepest = triangles[order].reshape(-1, 3, 3), np.zeros(len(order), int), [(0, 1)], 0
    while todo:
        node, depth = todo.pop()
        deepest, (first, count) = max(deepest, depth), links[node]
        if count:
            seen[first:first + count] += 1
            points = rows[first:first + count].reshape(-1, 3)
            assert np.array_equal(boxes[node], np.concatenate([points.min(0), points.max(0)])) and count <= LEAF
        else:
            left, right = boxes[first], boxes[first + 1]
            assert np.array_equal(boxes[node], np.concatenate([np.minimum(left, right)[:3], np.maximum(left, right)[3:]]))
            todo += [(first, depth + 1), (first + 1, depth + 1)]
    assert (seen == 1).all() and deepest < BVH_STACK


def test_one_triangle_is_one_leaf():
    boxes, links, order = build_bvh(np.arange(9.0)[None])
    assert boxes.tolist() == [[0, 1, 2, 6, 7, 8]] and links.tolist() == [[0, 1]] and order.tolist() == [0]
