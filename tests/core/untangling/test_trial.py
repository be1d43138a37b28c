import numpy as np

from npm_blender.core.decimation.qem import decimate
from npm_blender.core.geometry.geodesic_trace import SurfacePoints, TraceMesh
from npm_blender.core.geometry.normals import vertex_normals
from npm_blender.core.levels.lod_sequence import build_levels
from npm_blender.core.mesh.subdivision import hierarchy
from npm_blender.core.untangling.one_rings import one_rings_of
from npm_blender.core.untangling.propagation import propagate
from npm_blender.core.untangling.trial import (
    TIME,
    TrialRegion,
    add,
    begin,
    changed,
    commit,
    fitness,
    gather,
    restore,
    save,
)
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
        self.region = TrialRegion.make(self.H[-1].n, len(self.rings.F), LEVELS, 10)
        self.v = int(np.flatnonzero(~self.rings.fixed[:len(lod.V0)])[0])

    def propagated(self, step=0.0):
        begin(self.region)
        count = gather(self.rings, -1, self.region, add(self.v, self.region, 0))
        save(self.points, self.region, count)
        self.points.P[self.v, 0] += step
        done, whole = propagate(self.surface, self.rings, self.points, -1, self.region, len(self.rings.F))
        assert whole and done == count - 1
        return count


def test_what_is_restored_is_as_before_to_the_last_bit():
    flat = Flat()
    before = [x.copy() for x in flat.points]
    count = flat.propagated(0.01)
    assert np.abs(flat.points.P - before[2]).max() > 1e-6
    restore(flat.points, flat.region, count)
    assert all(np.array_equal(x, y) for x, y in zip(flat.points, before))


def test_a_region_has_the_faces_of_all_levels_round_its_vertices_coarse_before_fine():
    flat = Flat()
    count = flat.propagated()
    region, rings = flat.region, flat.rings
    seen = region.faces[:region.faces_to[-1]]
    assert set(seen) == set(np.flatnonzero(np.isin(rings.F, region.vertices[:count]).any(1)))
    for k in range(LEVELS):
        first = region.faces_to[k - 1] if k else 0
        here = seen[first:region.faces_to[k]]
        assert ((here >= rings.first[k]) & (here < rings.first[k + 1])).all() and len(here) == len(set(here)) > 0


def test_on_a_flat_sheet_the_covered_area_is_that_of_the_region_and_falls_when_it_folds():
    flat = Flat()
    count = flat.propagated()
    assert count > 10
    seen = flat.region.faces[:flat.region.faces_to[-1]]
    fine = flat.rings.F[seen[seen >= flat.rings.first[-2]]]
    a, b, c = flat.points.P[fine].swapaxes(0, 1)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() * 3
    count, height, covered = fitness(flat.rings, flat.points, flat.region)
    assert count == 0 and height < 1e-12 and abs(covered - area) < 1e-9
    flat.points.P[flat.v, :2] += 0.3  # out of its ring
    count, _, folded = fitness(flat.rings, flat.points, flat.region)
    assert count > 0 and abs(folded - covered) < 1e-9  # a fold inside a plane covers the same, less what it takes away


def test_a_face_counts_as_changed_until_it_failed_and_after_a_neighbour_moved():
    flat = Flat()
    f = int(np.flatnonzero((flat.rings.F == flat.v).any(1))[0])
    flat.region.state[TIME] = last = 1
    assert changed(flat.rings, f, 0, flat.region.times.moved)
    assert not changed(flat.rings, f, last, flat.region.times.moved)
    commit(flat.region, flat.propagated())
    assert changed(flat.rings, f, last, flat.region.times.moved)


def test_a_region_for_another_thread_shares_what_happened_for_good_and_nothing_else():
    flat = Flat()
    flat.region.set_work(123)
    flat.propagated()
    other = flat.region.another()
    assert other.work_left == 123 and other.time == flat.region.time and not other.mark.any() and not other.seen.any()
    flat.region.set_work(7)
    flat.region.times.moved[3] = 9
    assert other.work_left == 123 and other.times.moved[3] == 9
    assert not np.shares_memory(other.vertices, flat.region.vertices)
    assert all(not np.shares_memory(a, b) for a, b in zip(other.saved, flat.region.saved, strict=True))
    assert flat.region.saved.face.dtype == np.int32 and flat.region.search.face.dtype == np.int64
