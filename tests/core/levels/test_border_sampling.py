"""Open borders stay: every loop of the finest level is as long as the input's, and lies on it."""
import numpy as np
import pytest

from npm_blender.core.cleaning.cleanup import clean
from npm_blender.core.geometry.closest_point import ClosestPoints
from npm_blender.core.levels.lod_sequence import build_lod
from npm_blender.core.mesh.components import component_labels
from npm_blender.core.mesh.subdivision import hierarchy
from npm_blender.core.mesh.topology import opposite_halfedges
from npm_blender.core.mesh.triangle_mesh import TriMesh, UnitFrame
from npm_blender.core.settings import LodSettings
from tests.meshes.dirty_meshes import mesh, moebius, plane, sphere, tube, wave, without


def ring(n=80, k=10, radius=lambda w: 1 + 0 * w):
    """A flat ring from 0.4 to 1 times radius(angle)."""
    w = np.arange(n) * 2 * np.pi / n
    r = np.outer(np.linspace(0.4, 1, k + 1), radius(w))
    V = np.stack([r * np.cos(w), r * np.sin(w), 0 * r], 2).reshape(-1, 3)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(k), np.arange(n), indexing="ij"))
    a, b = i * n + j, i * n + (j + 1) % n
    return mesh(V, np.concatenate([np.stack([a, a + n, b + n], 1), np.stack([a, b + n, b], 1)]))


def bowl():
    """A sphere cut off along its triangles: a zigzag rim."""
    m = sphere(4)
    return mesh(m.V, m.F[m.V[m.F][:, :, 2].mean(1) > 0.1])


def frame():
    m = plane(30)
    return without(m, np.flatnonzero((np.abs(m.V[m.F].mean(1)[:, :2] - 0.5) < 0.2).all(1)))


OPEN = {"square": lambda: plane(30), "waves": lambda: wave(40), "tube": lambda: tube(20, 60), "ring": ring, "bowl": bowl,
        "frame": frame, "Moebius strip, cut": lambda: moebius(400),
        "gear": lambda: ring(radius=lambda w: np.where((np.arange(len(w)) // 4) % 2, 0.6, 1.0))}


def border_loops(m):
    """Border edges (k, 2) of a mesh, and for each the number of its loop."""
    opposite = opposite_halfedges(m.F)
    h = np.flatnonzero(opposite == np.arange(m.F.size))
    edges = np.stack([m.F.reshape(-1)[h], np.roll(m.F, -1, 1).reshape(-1)[h]], 1)
    return edges, np.unique(component_labels(len(m.V), *edges.T)[edges[:, 0]], return_inverse=True)[1].reshape(-1)


@pytest.mark.parametrize("name", OPEN)
def test_every_border_loop_keeps_its_length_and_place(name):
    cleaned, _ = clean(OPEN[name]())
    unit = TriMesh(UnitFrame.of(cleaned.V).to_unit(cleaned.V), cleaned.F)
    lod = build_lod(unit, LodSettings(base_faces=400, levels=3))
    fine = TriMesh(lod.V, hierarchy(lod.F0, len(lod.V0), 3)[-1].F)
    edges, loop = border_loops(unit)
    fine_edges, fine_loop = border_loops(fine)
    assert fine_loop.max() == loop.max()
    # each fine loop lies on one loop of the input; segments are triangles without area for the search
    rim = ClosestPoints(TriMesh(unit.V, edges[:, [0, 1, 1]].astype(np.int32)))
    distance, _, on = rim.closest(fine.V[fine_edges[:, 0]])
    assert distance.max() < 1e-6
    for k in range(loop.max() + 1):
        whose = np.unique(loop[on[fine_loop == k]])
        assert len(whose) == 1
        lengths = [np.linalg.norm(m.V[e[:, 0]] - m.V[e[:, 1]], axis=1).sum()
                   for m, e in ((fine, fine_edges[fine_loop == k]), (unit, edges[loop == whose[0]]))]
        assert lengths[0] == pytest.approx(lengths[1], rel=0.02)
    # the other way: no corner of the rim is cut off
    back = ClosestPoints(TriMesh(fine.V, fine_edges[:, [0, 1, 1]].astype(np.int32)))
    assert back.closest(unit.V[edges[:, 0]])[0].max() < 0.01


@pytest.mark.parametrize("lobes, base_faces, tolerance", [(14, 80, 0.001), (20, 120, 0.001), (30, 100, 0.01)])
def test_a_loop_with_more_corners_than_the_base_keeps_its_length(lobes, base_faces, tolerance):
    m = ring(n=10 * lobes, radius=lambda w: 1 + 0.1 * (np.arange(len(w)) % 10 < 5))
    unit = TriMesh(UnitFrame.of(m.V).to_unit(m.V), m.F)
    lod = build_lod(unit, LodSettings(base_faces=base_faces, levels=3))
    fine = TriMesh(lod.V, hierarchy(lod.F0, len(lod.V0), 3)[-1].F)
    there, here = (np.linalg.norm(np.subtract(*m.V[border_loops(m)[0].T]), axis=1).sum() for m in (fine, unit))
    assert there == pytest.approx(here, rel=tolerance)


def test_a_strip_with_a_long_border_takes_no_long_time_with_few_base_edges(monkeypatch):
    from npm_blender.core.levels import border_sampling

    k = 30_000
    x = np.linspace(0, 1, k)
    V = np.stack([np.repeat(x, 2), 0.05 * (np.arange(2 * k) % 2) + 0.01 * np.sin(40 * np.repeat(x, 2)), np.zeros(2 * k)], 1)
    a = 2 * np.arange(k - 1)
    strip = TriMesh.from_arrays(V, np.concatenate([np.stack([a, a + 2, a + 1], 1), np.stack([a + 1, a + 2, a + 3], 1)]))
    tried = []
    choose = border_sampling._choose

    def counted(X, *others):
        tried.append(len(X))
        choose(X, *others)

    monkeypatch.setattr(border_sampling, "_choose", counted)
    monkeypatch.setattr(border_sampling, "_slide", border_sampling._slide.py_func)  # so that it finds the name in the module
    lod = build_lod(strip, LodSettings(base_faces=8, levels=3))
    assert max(tried) <= border_sampling.MOST + 8 and len(lod.F0) <= 8
    finest = hierarchy(lod.F0, len(lod.V0), 3)[-1]
    there, before = (TriMesh(V, F).V[_border_edges(F)] for V, F in ((lod.V, finest.F), (strip.V, strip.F)))
    length, whole = (np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() for ends in (there, before))
    assert length == pytest.approx(whole, rel=0.02)


def _border_edges(F):
    h = np.flatnonzero(opposite_halfedges(F) == np.arange(F.size))
    corner = F.reshape(-1)
    return np.stack([corner[h], corner[h - h % 3 + (h + 1) % 3]], 1)
