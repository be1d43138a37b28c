import numpy as np

from npm_blender.core.decimate import decimate
from npm_blender.core.lod import levels
from npm_blender.core.normals import vertex_normals
from npm_blender.core.patch import Patch, add, carry, changed, faces_round, fitness, settled, swap
from npm_blender.core.relax import rings_of
from npm_blender.core.subdivide import hierarchy
from npm_blender.core.walk import Points, Surface

from .lod_meshes import sheet

LEVELS = 3


class Flat:
    """The levels of a flat sheet as `relax` sees them, and one base vertex inside."""

    def __init__(self):
        mesh = sheet(flat=True)
        d = decimate(mesh, 40)
        lod = levels(d, LEVELS, fitted=False)
        self.H = hierarchy(lod.F0, len(lod.V0), LEVELS)
        self.rings = rings_of(self.H)
        self.surface = Surface(mesh.V, mesh.F, d.opposite, vertex_normals(mesh))
        self.points = Points(lod.source_face.copy(), lod.barycentric.copy(), lod.V.copy(), lod.N.copy())
        self.patch = Patch.make(self.H[-1].n, len(self.rings.F), LEVELS, 10)
        self.v = int(np.flatnonzero(~self.rings.fixed[:len(lod.V0)])[0])

    def carried(self):
        self.patch.state[0] += 1
        count = add(self.points, self.v, self.patch, 0)
        return carry(self.surface, self.rings, self.points, -1, self.patch, count)


def test_finer_vertices_are_carried_to_the_middles_of_their_edges():
    flat = Flat()
    count = flat.carried()
    base_faces = (flat.H[0].F == flat.v).any(1)
    inside = np.setdiff1d(np.unique(flat.H[-1].F.reshape(len(flat.H[0].F), -1)[base_faces]),
                          np.unique(flat.H[-1].F.reshape(len(flat.H[0].F), -1)[~base_faces]))
    assert set(flat.patch.vertices[:count]) == set(inside) - set(np.flatnonzero(flat.rings.fixed))
    first = flat.H[0]
    for e, (i, j) in enumerate(first.edges):  # the vertices of level 1 come after those of the base, in the order of its edges
        if flat.v in (i, j):
            middle = (flat.points.P[i] + flat.points.P[j]) / 2
            assert np.abs(flat.points.P[first.n + e] - middle).max() < 1e-9


def test_what_is_swapped_back_is_as_before():
    flat = Flat()
    before = flat.points.P.copy(), flat.points.face.copy()
    count = flat.carried()
    after = flat.points.P.copy()
    assert np.abs(after - before[0]).max() > 1e-6
    swap(flat.surface, flat.points, flat.patch, count)
    assert np.allclose(flat.points.P, before[0], atol=1e-12) and np.array_equal(flat.points.face, before[1])
    swap(flat.surface, flat.points, flat.patch, count)
    assert np.allclose(flat.points.P, after, atol=1e-12)


def test_on_a_flat_sheet_the_covered_area_is_that_of_the_patch_and_falls_when_it_folds():
    flat = Flat()
    count = flat.carried()
    faces = faces_round(flat.rings, flat.patch, count)
    seen = flat.patch.faces[:faces]
    assert len(set(seen)) == faces
    fine = flat.rings.F[seen[seen >= flat.rings.first[-2]]]
    a, b, c = flat.points.P[fine].swapaxes(0, 1)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() * 3
    turned, height, covered = fitness(flat.rings, flat.points, flat.patch, faces)
    assert turned == 0 and height < 1e-12 and abs(covered - area) < 1e-9
    flat.points.P[flat.v, :2] += 0.3  # out of its ring
    turned, _, folded = fitness(flat.rings, flat.points, flat.patch, faces)
    assert turned > 0 and abs(folded - covered) < 1e-9  # a fold inside a plane covers the same, less what it takes away


def test_a_face_counts_as_changed_until_it_failed_and_after_a_neighbour_moved():
    flat = Flat()
    f = int(np.flatnonzero((flat.rings.F == flat.v).any(1))[0])
    assert changed(flat.rings, f, flat.patch)
    flat.patch.state[3] += 1
    flat.patch.failed[f] = flat.patch.state[3]
    assert not changed(flat.rings, f, flat.patch)
    settled(flat.patch, flat.carried())
    assert changed(flat.rings, f, flat.patch)
