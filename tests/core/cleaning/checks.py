"""What every cleaned mesh has to be."""
from npm_blender.core.cleaning import inspect
from npm_blender.core.mesh import opposite_halfedges, vertex_fans


def assert_manifold(m):
    fans = vertex_fans(m.F, opposite_halfedges(m.F), len(m.V))  # raises where an edge is not manifold and oriented
    assert (fans == 1).all()  # no vertex pinched, none unused
    assert inspect(m).problems == ()
