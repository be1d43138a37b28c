
from npm_blender.core.cleaning.cleanup import inspect
from tests.meshes.dirty_meshes import (
    book,
    box,
    joined,
    more,
    pinched_spheres,
    plane,
    soup,
    sphere,
    turn,
)


def test_inspect_counts():
    m = more(turn(joined(box(), sphere(at=(5, 0, 0))), [0]), [[7, 7, 7], *box().V[:2]],
             [[0, 0, 1], [*box().F[5]], [0, 1, 219]])
    report = inspect(m)
    assert (report.vertices, report.faces) == (len(m.V), len(m.F))
    assert report.unused_vertices == 2 and report.repeated_corner_faces == 1 and report.duplicate_faces == 1
    assert report.misoriented_edges == 3 and report.components == 2
    assert inspect(book(5)).nonmanifold_edges == 4 and inspect(pinched_spheres()).pinched_vertices == 1
    assert inspect(plane()).border_edges == 16 and inspect(plane()).border_loops == 1
    assert inspect(soup(sphere())).coincident_vertices == 960 - 162
