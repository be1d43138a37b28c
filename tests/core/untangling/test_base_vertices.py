import numpy as np

from npm_blender.core.decimation.qem import decimate
from npm_blender.core.geometry.geodesic_trace import TraceMesh, points_on, trace_geodesic
from npm_blender.core.geometry.normals import vertex_normals
from npm_blender.core.levels.lod_sequence import build_levels
from npm_blender.core.mesh.subdivision import hierarchy
from npm_blender.core.mesh.topology import opposite_halfedges
from npm_blender.core.mesh.triangle_mesh import TriMesh
from npm_blender.core.untangling.base_vertices import return_to_base_positions
from npm_blender.core.untangling.one_rings import one_rings_of
from npm_blender.core.untangling.rounds import untangle
from npm_blender.core.untangling.trial import TrialRegion
from tests.meshes.lod_meshes import sheet, sphere


def places(mesh, face, b):
    return np.einsum("nk,nkd->nd", b, mesh.V[mesh.F[face]])


def test_a_base_vertex_returns_to_its_position_and_the_finer_ones_follow():
    mesh = sphere(5)
    lod = build_levels(decimate(mesh, 60), 2, fitted=False)
    H = hierarchy(lod.F0, len(lod.V0), 2)
    face, b = lod.source_face.copy(), lod.barycentric.copy()
    surface = TraceMesh(mesh.V, mesh.F, opposite_halfedges(mesh.F), vertex_normals(mesh))
    level1 = np.unique(H[1].F[(H[1].F == 7).any(1)])
    away = np.cross(lod.N[7], [0.3, 0.5, 0.8])
    face[7] = trace_geodesic(surface, face[7], b[7], *(0.15 * away / np.linalg.norm(away)))
    before = places(mesh, face, b)
    points = points_on(surface, face, b)
    untangle(surface, points, H, lod.V0)
    after = places(mesh, points.face, points.b)
    assert np.linalg.norm(after[7] - lod.V0[7]) < 0.3 * np.linalg.norm(before[7] - lod.V0[7])
    moved = np.flatnonzero(np.abs(after - before).max(1) > 1e-9)
    assert set(level1) <= set(moved) and len(moved) < 0.2 * len(after)
    assert ((TriMesh(after, H[-1].F).face_normals() * after[H[-1].F].mean(1)).sum(1) > 0).all()


def test_no_base_vertex_leaves_the_surface_for_its_position():
    mesh = sheet(noise=0.01)
    d = decimate(mesh, 40)
    lod = build_levels(d, 2, fitted=False)
    H = hierarchy(lod.F0, len(lod.V0), 2)
    face, b = lod.source_face, lod.barycentric
    region = TrialRegion.make(H[-1].n, sum(len(level.F) for level in H[1:]), 2, 0)
    above = lod.V0 + [0, 0, 1.0]  # no trace over the surface gets nearer
    surface = TraceMesh(mesh.V, mesh.F, d.opposite, vertex_normals(mesh))
    points = points_on(surface, face, b)
    assert return_to_base_positions(surface, one_rings_of(H), points, above, 0, len(above), region) == 0
    assert np.array_equal(points.face, face) and np.allclose(points.b, b)
