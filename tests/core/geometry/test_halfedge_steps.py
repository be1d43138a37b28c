import numpy as np

from npm_blender.core.geometry.halfedge_steps import end_of, next_halfedge, prev_halfedge
from npm_blender.core.mesh.topology import directed_edges
from tests.meshes.lod_meshes import torus


def test_steps_stay_in_the_face_and_undo_each_other():
    for h in range(30):
        assert next_halfedge(h) // 3 == prev_halfedge(h) // 3 == h // 3
        assert prev_halfedge(next_halfedge(h)) == next_halfedge(prev_halfedge(h)) == h
        assert next_halfedge(next_halfedge(next_halfedge(h))) == h != next_halfedge(h)


def test_the_end_of_a_halfedge_is_where_the_next_one_starts():
    F = torus(4, 5).F
    flat = F.reshape(-1)
    ends = [end_of(flat, h) for h in range(F.size)]
    assert ends == [flat[next_halfedge(h)] for h in range(F.size)] and np.array_equal(ends, directed_edges(F)[:, 1])
