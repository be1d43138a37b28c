import numpy as np

from npm_blender.core.decimation.qem import decimate
from npm_blender.core.geometry.geodesic_trace import SurfacePoints, TraceMesh
from npm_blender.core.geometry.normals import vertex_normals
from npm_blender.core.levels.lod_sequence import build_levels
from npm_blender.core.mesh.subdivision import hierarchy
from npm_blender.core.untangling.one_rings import one_rings_of
from npm_blender.core.untangling.propagation import propagate
from npm_blender.core.untangling.trial import TrialRegion, add, changed, commit, fitness, gather, restore, save, turned
from tests.meshes.lod_meshes import sheet

LEVELS = 3


class Flat:
    """The levels of a flat sheet as `untangle` sees them, and one base vertex inside."""

    def __init__(self):
        mesh = sheet(flat=True)
        d = decimate(mesh, 40)
        lod = build_levels(d, LEVELS, fitted=False)
        self.H = hierarchy(lod.F0, len(lod.V0), LEVELS)
        self.rings = one_rings_of(self.H)
        self.surface = TraceMesh(mesh.V, mesh.F, d.opposite, vertex_normals(mesh))
        self.points = SurfacePoints(lod.source_face.copy(), lod.barycentric.copy(), lod.V.copy(), lod.N.copy())
        self.patch = TrialRegion.make(self.H[-1].n, len(self.rings.F), LEVELS, 10)
        self.v = int(np.flatnonzero(~self.rings.fixed[:len(lod.V0)])[0])

    def carried(self, step=0.0):
        self.patch.state[0] += 1
        count = gather(self.rings, -1, self.patch, add(self.v, self.patch, 0))
        save(self.points, self.patch, count)
        self.points.P[self.v, 0] += step
        done, whole = propagate(self.surface, self.rings, self.points, -1, self.patch, len(self.rings.F))
        assert whole and done == count - 1
        return count


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


def test_what_is_restored_is_as_before_to_the_last_bit():
    flat = Flat()
    before = [x.copy() for x in flat.points]
    count = flat.carried(0.01)
    assert np.abs(flat.points.P - before[2]).max() > 1e-6
    restore(flat.points, flat.patch, count)
    assert all(np.array_equal(x, y) for x, y in zip(flat.points, before))


def test_a_patch_has_the_faces_of_all_levels_round_its_vertices_coarse_before_fine():
    flat = Flat()
    count = flat.carried()
    patch, rings = flat.patch, flat.rings
    seen = patch.faces[:patch.faces_to[-1]]
    assert set(seen) == set(np.flatnonzero(np.isin(rings.F, patch.vertices[:count]).any(1)))
    for k in range(LEVELS):
        first = patch.faces_to[k - 1] if k else 0
        here = seen[first:patch.faces_to[k]]
        assert ((here >= rings.first[k]) & (here < rings.first[k + 1])).all() and len(here) == len(set(here)) > 0


def test_carrying_stops_where_a_level_has_more_turned_faces_than_may_be():
    flat = Flat()
    count = flat.carried()
    restore(flat.points, flat.patch, count)
    flat.points.P[flat.v, :2] += 0.5  # out of its ring
    folded = turned(flat.rings, flat.points, flat.patch, 0, flat.patch.faces_to[-1], 1000)
    finest = turned(flat.rings, flat.points, flat.patch, *flat.patch.faces_to[-2:], 1000)
    assert 1 < finest < folded
    assert turned(flat.rings, flat.points, flat.patch, 0, flat.patch.faces_to[-1], 0) == 1
    done, whole = propagate(flat.surface, flat.rings, flat.points, -1, flat.patch, 0)
    assert not whole and done == flat.patch.vertices_to[0] - 1


def test_on_a_flat_sheet_the_covered_area_is_that_of_the_patch_and_falls_when_it_folds():
    flat = Flat()
    count = flat.carried()
    assert count > 10
    seen = flat.patch.faces[:flat.patch.faces_to[-1]]
    fine = flat.rings.F[seen[seen >= flat.rings.first[-2]]]
    a, b, c = flat.points.P[fine].swapaxes(0, 1)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() * 3
    count, height, covered = fitness(flat.rings, flat.points, flat.patch)
    assert count == 0 and height < 1e-12 and abs(covered - area) < 1e-9
    flat.points.P[flat.v, :2] += 0.3  # out of its ring
    count, _, folded = fitness(flat.rings, flat.points, flat.patch)
    assert count > 0 and abs(folded - covered) < 1e-9  # a fold inside a plane covers the same, less what it takes away


def test_a_face_counts_as_changed_until_it_failed_and_after_a_neighbour_moved():
    flat = Flat()
    f = int(np.flatnonzero((flat.rings.F == flat.v).any(1))[0])
    flat.patch.state[3] = last = 1
    assert changed(flat.rings, f, 0, flat.patch.moved)
    assert not changed(flat.rings, f, last, flat.patch.moved)
    commit(flat.patch, flat.carried())
    assert changed(flat.rings, f, last, flat.patch.moved)
