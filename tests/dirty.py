"""Named damages, each a kind that meshes from the wild have: what makes it, and what `clean` is to make of it."""
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from npm_blender.core.mesh.triangle_mesh import TriMesh
from npm_blender.core.meshio.mesh_files import read_mesh
from tests.meshes.dirty_meshes import (
    bipyramid,
    book,
    box,
    cells,
    collapsed_edge,
    far_soup,
    fins,
    flipped,
    glued,
    joined,
    klein,
    many_parts,
    mesh,
    moebius,
    more,
    moved,
    needles,
    noisy_soup,
    pinched_spheres,
    plane,
    polygons_as_obj,
    prism_of_star,
    shelf,
    soup,
    sphere,
    street,
    tetrahedron,
    tube,
    turn,
    unequal_sides,
    volume,
    wave,
    with_cap,
    without,
)


class Dirty(NamedTuple):
    """make: the mesh; components, loops, volume: after cleaning, None where it does not matter; words: in the report,
    '' where the mesh is to be left as it is."""

    make: Callable[[], TriMesh]
    components: int | None
    loops: int | None
    volume: float | None
    words: str


def read_text(suffix: str, text: str) -> TriMesh:
    """The mesh that the reader for `suffix` finds in a text."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "mesh" + suffix)
        path.write_text(text)
        return read_mesh(path)


DIRTY = {
    "triangle soup of an STL": Dirty(lambda: soup(sphere()), 1, 0, volume(sphere()), "merged 798 duplicate vertices"),
    "soup with float noise": Dirty(noisy_soup, 1, 0, volume(sphere()), "merged 798"),
    "cut along texture seams": Dirty(lambda: joined(mesh(sphere().V, sphere().F[:100]), mesh(sphere().V, sphere().F[100:])), 1, 0,
                                volume(sphere()), "merged"),
    "unused vertices": Dirty(lambda: more(sphere(), [[9, 9, 9], [0, 0, 0]]), 1, 0, volume(sphere()), "dropped 2 unused vertices"),
    "repeated corners": Dirty(lambda: more(sphere(), F=[[0, 0, 1], [2, 2, 2]]), 1, 0, volume(sphere()),
                         "dropped 2 faces with repeated corners"),
    "duplicate faces": Dirty(lambda: more(sphere(), F=sphere().F[:7]), 1, 0, volume(sphere()), "dropped 7 duplicate faces"),
    "two-sided card": Dirty(lambda: more(plane(), F=plane().F[:, ::-1]), 1, 1, 0, "dropped 32 duplicate faces"),
    "duplicate object at one place": Dirty(lambda: joined(sphere(), sphere()), 1, 0, volume(sphere()),
                                           "dropped 320 faces of parts that lie on others"),
    "duplicate object, vertices merged": Dirty(lambda: glued(sphere(), sphere()), 1, 0, volume(sphere()),
                                               "dropped 320 duplicate"),
    "some faces turned": Dirty(lambda: turn(sphere(), slice(0, 50)), 1, 0, volume(sphere()), "turned 50 faces to agree"),
    "most faces turned": Dirty(lambda: turn(sphere(), slice(0, 300)), 1, 0, volume(sphere()), "turned 300 faces to agree"),
    "inside out": Dirty(lambda: turn(sphere(), slice(None)), 1, 0, volume(sphere()), "turned 320 faces outward"),
    "one of two objects inside out": Dirty(lambda: joined(turn(sphere(), slice(None)), sphere(at=(3, 0, 0))), 2, 0,
                                      2 * volume(sphere()), "turned 320 faces outward"),
    "every face at random": Dirty(lambda: turn(sphere(), np.random.default_rng(1).random(320) < 0.5), 1, 0, volume(sphere()),
                             "faces to agree"),
    "some faces of an open sheet turned": Dirty(lambda: turn(plane(), [3, 4, 5]), 1, 1, 0, "turned 3 faces to agree"),
    "fin on a closed surface": Dirty(lambda: more(box(), [[0.5, 0.5, 3]], [[*box().F[0][:2], 56]]), 2, 1, 1, "non-manifold edge"),
    "inner wall": Dirty(lambda: glued(box(), mesh(plane(3).V + [0, 0, 1 / 3], plane(3).F)), 2, 1, None, "non-manifold edges"),
    "two cubes that share an edge": Dirty(lambda: glued(box(), box(at=(1, 1, 0))), 2, 0, 2, "cut the surface at 3 non-manifold"),
    "two cubes that share a corner": Dirty(lambda: glued(box(), box(at=(1, 1, 1))), 2, 0, 2, "split off 1 vertex"),
    "two cubes that share a wall": Dirty(lambda: glued(box(), box(at=(1, 0, 0))), 1, 0, 2,
                                         "dropped 36 faces of inner walls"),
    "two-sided shelf in an open box": Dirty(shelf, 2, 2, None, "dropped 18 duplicate faces"),
    "cubes that touch, not merged": Dirty(lambda: joined(box(), box(at=(1, 1, 0))), 2, 0, 2, ""),
    "book of three pages": Dirty(lambda: book(3), 3, 3, 0, "non-manifold edges"),
    "book of four pages": Dirty(lambda: book(4), None, None, None, "non-manifold edges"),
    "pinched spheres": Dirty(lambda: pinched_spheres(), 2, 0, None, "split off 1 vertex"),
    "sheets that meet in a point": Dirty(lambda: glued(plane(), mesh(plane().V + [1, 1, 0], plane().F)), 2, 2, 0,
                                    "split off 1 vertex"),
    "Moebius strip": Dirty(lambda: moebius(), 1, 1, None, "cut the surface"),
    "Klein bottle": Dirty(lambda: klein(), None, None, None, "cut the surface"),
    "cap without area": Dirty(lambda: with_cap(sphere()), 1, 0, volume(sphere()), "removed 1 face without area"),
    "collapsed edge": Dirty(lambda: collapsed_edge(sphere()), 1, 0, None, "collapsed 1 edge of zero length"),
    "flat face on the border": Dirty(lambda: more(plane(), [[0.125, 0, 0]], [[0, 25, 5]]), 1, 1, 0,
                                     "removed 1 face without area"),
    "holes that touch": Dirty(lambda: without(sphere(), np.arange(0, 320, 9)), 1, None, None, "split off"),
    "self-intersecting objects": Dirty(lambda: joined(sphere(), sphere(at=(0.7, 0, 0))), 2, 0, 2 * volume(sphere()), ""),
    "object in an object, a cavity": Dirty(lambda: joined(sphere(), turn(sphere(1, size=0.3), slice(None))), 2, 0,
                                      volume(sphere()) - volume(sphere(1, size=0.3)), ""),
    "a cavity, the whole inside out": Dirty(lambda: joined(turn(sphere(), slice(None)), sphere(1, size=0.3)), 2, 0,
                                       volume(sphere()) - volume(sphere(1, size=0.3)), "faces outward"),
    "loose debris": Dirty(lambda: joined(sphere(), mesh(np.eye(3) + 5, [[0, 1, 2]])), 2, 1, None, ""),
    "faces with no shared vertices at all": Dirty(lambda: mesh(np.random.default_rng(2).normal(size=(90, 3)),
                                                  np.arange(90).reshape(-1, 3)), 30, 30, None, ""),
    "far from the origin, very small": Dirty(lambda: soup(mesh(sphere().V * 1e-6 + 1000, sphere().F)), 1, 0, None, "merged"),
    "huge units": Dirty(lambda: soup(mesh(sphere().V * 1e12, sphere().F)), 1, 0, volume(sphere()) * 1e36, "merged"),
    "double-sided card, vertices not merged": Dirty(lambda: joined(plane(), flipped(plane())), 1, 1, 0, "dropped"),
    "three copies of an object": Dirty(lambda: joined(sphere(), sphere(), sphere()), 1, 0, volume(sphere()), "dropped"),
    "soup with every face doubled": Dirty(lambda: soup(joined(sphere(), sphere())), 1, 0, volume(sphere()), "dropped"),
    "cubes that share a wall, not merged": Dirty(lambda: joined(box(), box(at=(1, 0, 0))), 2, 0, 2, ""),
    "voxels with walls between them": Dirty(cells, 1, 0, 8, "dropped 192 faces of inner walls"),
    "T-junctions": Dirty(unequal_sides, 1, 0, 1, "closed 16 T-junctions"),
    "T-junctions in a soup": Dirty(lambda: soup(unequal_sides()), 1, 0, 1, "closed 16 T-junctions"),
    "noisy soup with a loose vertex far away": Dirty(lambda: more(noisy_soup(), [[1e9, 0, 0]]), 1, 0, volume(sphere()),
                                                     "merged 798"),
    "one part tiny beside a huge one": Dirty(lambda: joined(moved(wave(), 1e7), moved(wave(), by=(0, 0, 1e7))), 2, 2,
                                             None, ""),
    "needles, a million times as long as wide": Dirty(needles, 1, 0, 1, ""),
    "a plate of two sides 1e-9 apart": Dirty(lambda: mesh(box(5).V * [1, 1, 1e-9], box(5).F), 1, 0, None, ""),
    "two sheets 1e-9 apart": Dirty(lambda: joined(plane(8), moved(flipped(plane(8)), by=(0, 0, 1e-9))), None, None,
                                   None, "merged"),
    "a vertex of 5000 faces": Dirty(lambda: bipyramid(5000), 1, 0, None, ""),
    "fifty tiny parts beside a big one": Dirty(lambda: many_parts(50), 51, 25, None, ""),
    "a sheet": Dirty(wave, 1, 1, None, ""),
    "an open tube": Dirty(tube, 1, 2, None, ""),
    "a hole of one face": Dirty(lambda: without(sphere(), [7]), 1, 1, None, ""),
    "many holes": Dirty(lambda: without(sphere(3), np.arange(0, 1280, 40)), 1, 27, None, "split off 4 vertices"),
    "a shell in a shell, not a cavity": Dirty(lambda: joined(sphere(), sphere(size=0.5)), 2, 0, None, ""),
    "spheres through each other, glued nowhere, one inside out": Dirty(
        lambda: joined(sphere(), flipped(sphere(at=(0.7, 0, 0)))), 2, 0, 2 * volume(sphere()), "turned 320 faces outward"),
    "edge shared by four faces of one surface": Dirty(lambda: glued(box(), box(at=(1, 0, 1))), 2, 0, 2, "non-manifold"),
    "tiny units": Dirty(lambda: moved(sphere(), 1e-20), 1, 0, None, ""),
    "huge units and far from the origin": Dirty(lambda: moved(sphere(), 1e12, (1e14, 0, 0)), 1, 0, None, ""),
    "far from the origin in single precision": Dirty(
        lambda: mesh((sphere(3).V * 10 + [5e6, 4e6, 0]).astype(np.float32), sphere(3).F), 1, 0, None, ""),
    "soup with single precision's noise, far away": Dirty(far_soup, 1, 0, None, "merged 798"),
    "walls near each other, far away": Dirty(street, 2, 2, None, ""),
    "half of the faces turned": Dirty(lambda: turn(sphere(), slice(0, 320, 2)), 1, 0, volume(sphere()), "turned 160"),
    "rows of fins on a closed surface": Dirty(fins, 13, 12, None, "cut the surface at 36 non-manifold edges"),
    "thousands of parts inside out": Dirty(
        lambda: joined(sphere(), *[moved(flipped(tetrahedron()), 0.01, (3 + k % 50, k // 50, 0)) for k in range(1000)]),
        1001, 0, None, "turned 4000 faces outward"),
    "one face turned": Dirty(lambda: turn(sphere(), [5]), 1, 0, volume(sphere()), "turned 1 face to agree"),
    "wide Moebius strip": Dirty(lambda: moebius(200), 1, 1, None, "cut the surface"),
    "quads and concave polygons as OBJ": Dirty(
        lambda: read_text(".obj", polygons_as_obj(*prism_of_star(), "l 1 2\nf 3 4\np 5")), 1, 0, None, ""),
}


class Refused(NamedTuple):
    """make: what gives the mesh, or raises itself; words: of the one line that refuses it."""

    make: Callable[[], TriMesh]
    words: str


REFUSED = {
    "NaN in one vertex": Refused(lambda: changed(sphere(), 7, np.nan), "found 1 vertices with NaN or infinity"),
    "infinity in one vertex": Refused(lambda: changed(sphere(), 7, np.inf), "found 1 vertices with NaN or infinity"),
    "NaN in an OBJ file": Refused(lambda: read_text(".obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "NaN"),
    "index out of range": Refused(lambda: mesh(sphere().V[:-1], sphere().F), "vertex indices 0..160, found 0..161"),
    "negative index": Refused(lambda: mesh(sphere().V, sphere().F - 1), "vertex indices 0..161, found -1..160"),
    "index beyond 32 bits": Refused(lambda: mesh(sphere().V, sphere().F.astype(np.int64) + 2**32), "vertex indices"),
    "index out of range in an OBJ file": Refused(
        lambda: read_text(".obj", polygons_as_obj(*prism_of_star(), "f 1 2 99")), "with 40 vertices"),
    "all vertices in one point": Refused(lambda: moved(sphere(), 0.0, (1, 2, 3)), "found only faces"),
    "all vertices on a line": Refused(lambda: mesh(wave().V * [1, 0, 0], wave().F), "found"),
    "only loose edges and points": Refused(lambda: read_text(".obj", "v 0 0 0\nv 1 0 0\nl 1 2\nf 1 2\n"),
                                           "points without faces"),
    "nothing but repeated corners": Refused(lambda: mesh(sphere().V, sphere().F[:, [0, 0, 1]]), "repeated corners"),
    "too small": Refused(tetrahedron, "at least 20 faces, found 4"),
    "too small once cleaned": Refused(lambda: joined(*[tetrahedron() for _ in range(6)]),
                                      "found 4 after cleaning (dropped 20 faces of parts that lie on others)"),
    "beyond all scales": Refused(lambda: moved(sphere(), 1e300), "extent from 1e-60 to 1e+60 units, found 2e+300"),
    "below all scales": Refused(lambda: moved(sphere(), 1e-300), "extent from 1e-60 to 1e+60 units, found 2e-300"),
}


def changed(m: TriMesh, vertex: int, value: float) -> TriMesh:
    """m with one coordinate changed."""
    V = m.V.copy()
    V[vertex, 1] = value
    return mesh(V, m.F)
