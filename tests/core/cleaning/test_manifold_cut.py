import numpy as np

from npm_blender.core.cleaning.edge_groups import EdgeGroups
from npm_blender.core.cleaning.manifold_cut import cut
from npm_blender.core.mesh import opposite_halfedges, vertex_fans
from tests.meshes.dirty_meshes import (
    book,
    pinched_spheres,
)


def test_pages_of_a_book_come_apart():
    m = book(4)
    V, F, opened, copies = cut(m.V, EdgeGroups.of(m.F, len(m.V)))
    assert opened > 0 and len(V) == len(m.V) + copies
    assert np.array_equal(V[F], m.V[m.F])  # the same faces
    assert EdgeGroups.of(F, len(V)).sizes.max() <= 2


def test_a_vertex_where_surfaces_meet_is_split_off():
    m = pinched_spheres()
    V, F, opened, copies = cut(m.V, EdgeGroups.of(m.F, len(m.V)))
    assert (opened, copies) == (0, 1) and (vertex_fans(F, opposite_halfedges(F), len(V)) == 1).all()
