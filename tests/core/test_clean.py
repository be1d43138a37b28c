import sys
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.clean import MIN_FACES, clean, inspect
from npm_blender.core.errors import Cancelled, DependencyError, MeshError
from npm_blender.core.flatfaces import remove_flat_faces
from npm_blender.core.mesh import TriMesh
from npm_blender.core.repair import FLAT, flatness
from npm_blender.core.subdivide import Level, midpoints
from npm_blender.core.topology import opposite_halfedges, topology_of, vertex_fans


def mesh(V, F):
    return TriMesh.from_arrays(np.asarray(V, float), np.asarray(F))


def box(n=3, at=(0, 0, 0), size=1.0):
    """A closed cube of n x n quads a side, outward: 12 n^2 faces."""
    V = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    quads = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
    t = np.linspace(0, 1, n + 1)
    u, v = (a.reshape(-1, 1) for a in np.meshgrid(t, t, indexing="ij"))
    points, faces = [], []
    for q in quads:
        a, b, d = V[q[0]], V[q[1]], V[q[3]]
        faces.append(plane(n).F + len(points) * (n + 1) ** 2)
        points.append(a + u * (b - a) + v * (d - a))
    P = np.round(np.concatenate(points), 12)
    unique, back = np.unique(P, axis=0, return_inverse=True)
    return mesh(unique * size + at, back.reshape(-1)[np.concatenate(faces)])


def plane(n=4):
    """An open grid of n x n quads in the plane z = 0, facing up: 2 n^2 faces."""
    t = np.arange(n + 1) / n
    V = np.array([[x, y, 0] for x in t for y in t])
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    a, b, c, d = i * (n + 1) + j, (i + 1) * (n + 1) + j, (i + 1) * (n + 1) + j + 1, i * (n + 1) + j + 1
    return mesh(V, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def sphere(levels=2, at=(0, 0, 0), size=1.0):
    g = (1 + 5**0.5) / 2
    V = np.array([[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g], [0, -1, -g], [0, 1, -g],
                  [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1]])
    level = Level.of(np.array([[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4],
                               [11, 10, 2], [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8],
                               [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]]), 12)
    for _ in range(levels):
        V, level = midpoints(V, level), level.subdivided()
    return mesh(V / np.linalg.norm(V, axis=1, keepdims=True) * size + at, level.F)


def joined(*meshes):
    offsets = np.cumsum([0] + [len(m.V) for m in meshes])
    return mesh(np.concatenate([m.V for m in meshes]),
                np.concatenate([m.F + o for m, o in zip(meshes, offsets, strict=False)]))


def soup(m):
    return mesh(m.V[m.F].reshape(-1, 3), np.arange(m.F.size).reshape(-1, 3))


def glued(*meshes, digits=9):
    """Join, and make vertices at the same place one, whatever comes of it."""
    m = joined(*meshes)
    V, back = np.unique(np.round(m.V, digits), axis=0, return_inverse=True)
    return mesh(V, back.reshape(-1)[m.F])


def volume(m):
    a, b, c = m.V[m.F].swapaxes(0, 1)
    return np.einsum("nx,nx->", a, np.cross(b, c)) / 6


def turn(m, faces):
    F = m.F.copy()
    F[faces] = F[faces][:, ::-1]
    return mesh(m.V, F)


def more(m, V=(), F=()):
    V, F = np.reshape(V, (-1, 3)), np.reshape(F, (-1, 3)).astype(int)
    return mesh(np.concatenate([m.V, V]), np.concatenate([m.F, F]))


def moebius(n=30):
    t = np.arange(n) * np.pi / n
    one = np.column_stack([np.cos(2 * t), np.sin(2 * t), 0 * t])
    across = 0.3 * np.column_stack([np.cos(t) * np.cos(2 * t), np.cos(t) * np.sin(2 * t), np.sin(t)])
    V = np.concatenate([one - across, one + across])
    F = []
    for i in range(n):
        a, b = i, n + i
        c, d = (i + 1, n + i + 1) if i < n - 1 else (n, 0)
        F += [[a, c, b], [b, c, d]]
    return mesh(V, F)


def klein(n=12, k=8):
    """A tube glued to itself with a reflection: closed and one-sided."""
    index = np.arange(n * k).reshape(n, k)
    F = []
    for i in range(n):
        for j in range(k):
            a, b = index[i, j], index[i, (j + 1) % k]
            c, d = index[i + 1, [j, (j + 1) % k]] if i < n - 1 else index[0, [-j % k, -(j + 1) % k]]
            F += [[a, c, b], [b, c, d]]
    return mesh(np.random.default_rng(0).normal(size=(n * k, 3)), F)


def with_cap(m):
    """A vertex on an edge's middle, used by one side only: a face without area fills the gap."""
    opposite = opposite_halfedges(m.F)
    a, b, c = m.F[0]
    assert opposite[0] != 0
    middle = len(m.V)
    F = np.concatenate([m.F[1:], [[a, middle, c], [middle, b, c], [a, b, middle]]])
    return mesh(np.concatenate([m.V, [(m.V[a] + m.V[b]) / 2]]), F)


def collapsed_edge(m):
    V = m.V.copy()
    V[m.F[0, 1]] = V[m.F[0, 0]]
    return mesh(V, m.F)


def pinched_spheres():
    a, b = sphere(), sphere(at=(2, 0, 0))
    top, bottom = a.V[:, 0].argmax(), b.V[:, 0].argmin()
    m = joined(mesh(a.V - a.V[top], a.F), mesh(b.V - b.V[bottom], b.F))
    F = m.F.copy()
    F[F == bottom + len(a.V)] = top
    return mesh(m.V, F)


def book(pages):
    """Sheets that share one edge."""
    angles = np.arange(pages) * 2 * np.pi / pages + 0.1
    return glued(*[mesh(plane().V @ np.array([[0, 0, 1], [np.cos(w), np.sin(w), 0], [0, 0, 0]]), plane().F)
                   for w in angles])


# name: (mesh, components after, border loops after, volume after or None, words expected in the report)
DIRTY = {
    "triangle soup of an STL": (soup(sphere()), 1, 0, volume(sphere()), "merged 798 duplicate vertices"),
    "soup with float noise": (mesh(soup(sphere()).V + np.random.default_rng(0).uniform(-2e-7, 2e-7, (960, 3)),
                                   soup(sphere()).F), 1, 0, volume(sphere()), "merged 798"),
    "cut along texture seams": (joined(mesh(sphere().V, sphere().F[:100]), mesh(sphere().V, sphere().F[100:])), 1, 0,
                                volume(sphere()), "merged"),
    "unused vertices": (more(sphere(), [[9, 9, 9], [0, 0, 0]]), 1, 0, volume(sphere()), "dropped 2 unused vertices"),
    "repeated corners": (more(sphere(), F=[[0, 0, 1], [2, 2, 2]]), 1, 0, volume(sphere()),
                         "dropped 2 faces with repeated corners"),
    "duplicate faces": (more(sphere(), F=sphere().F[:7]), 1, 0, volume(sphere()), "dropped 7 duplicate faces"),
    "two-sided card": (more(plane(), F=plane().F[:, ::-1]), 1, 1, 0, "dropped 32 duplicate faces"),
    "duplicate object at one place": (joined(sphere(), sphere()), 2, 0, 2 * volume(sphere()), ""),
    "duplicate object, vertices merged": (glued(sphere(), sphere()), 1, 0, volume(sphere()), "dropped 320 duplicate"),
    "some faces turned": (turn(sphere(), slice(0, 50)), 1, 0, volume(sphere()), "turned 50 faces to agree"),
    "most faces turned": (turn(sphere(), slice(0, 300)), 1, 0, volume(sphere()), "turned 300 faces to agree"),
    "inside out": (turn(sphere(), slice(None)), 1, 0, volume(sphere()), "turned 320 faces outward"),
    "one of two objects inside out": (joined(turn(sphere(), slice(None)), sphere(at=(3, 0, 0))), 2, 0,
                                      2 * volume(sphere()), "turned 320 faces outward"),
    "every face at random": (turn(sphere(), np.random.default_rng(1).random(320) < 0.5), 1, 0, volume(sphere()),
                             "faces to agree"),
    "some faces of an open sheet turned": (turn(plane(), [3, 4, 5]), 1, 1, 0, "turned 3 faces to agree"),
    "fin on a closed surface": (more(box(), [[0.5, 0.5, 3]], [[*box().F[0][:2], 56]]), 2, 1, 1, "non-manifold edge"),
    "inner wall": (glued(box(), mesh(plane(3).V + [0, 0, 1 / 3], plane(3).F)), 2, 1, None, "non-manifold edges"),
    "two cubes that share an edge": (glued(box(), box(at=(1, 1, 0))), 2, 0, 2, "cut the surface at 3 non-manifold"),
    "two cubes that share a corner": (glued(box(), box(at=(1, 1, 1))), 2, 0, 2, "split off 1 vertex"),
    "two cubes that share a wall": (glued(box(), box(at=(1, 0, 0))), None, None, None, "duplicate faces"),
    "cubes that touch, not merged": (joined(box(), box(at=(1, 1, 0))), 2, 0, 2, ""),
    "book of three pages": (book(3), 3, 3, 0, "non-manifold edges"),
    "book of four pages": (book(4), None, None, None, "non-manifold edges"),
    "pinched spheres": (pinched_spheres(), 2, 0, None, "split off 1 vertex"),
    "sheets that meet in a point": (glued(plane(), mesh(plane().V + [1, 1, 0], plane().F)), 2, 2, 0,
                                    "split off 1 vertex"),
    "Moebius strip": (moebius(), 1, 1, None, "cut the surface"),
    "Klein bottle": (klein(), None, None, None, "cut the surface"),
    "cap without area": (with_cap(sphere()), 1, 0, volume(sphere()), "removed 1 face without area"),
    "collapsed edge": (collapsed_edge(sphere()), 1, 0, None, "collapsed 1 edge of zero length"),
    "flat face on the border": (more(plane(), [[0.125, 0, 0]], [[0, 25, 5]]), 1, 1, 0, "removed 1 face without area"),
    "hole": (mesh(sphere().V, sphere().F[1:]), 1, 1, None, ""),
    "holes that touch": (mesh(sphere().V, np.delete(sphere().F, np.arange(0, 320, 9), 0)), 1, None, None, "split off"),
    "self-intersecting objects": (joined(sphere(), sphere(at=(0.7, 0, 0))), 2, 0, 2 * volume(sphere()), ""),
    "object in an object, a cavity": (joined(sphere(), turn(sphere(1, size=0.3), slice(None))), 2, 0,
                                      volume(sphere()) - volume(sphere(1, size=0.3)), ""),
    "a cavity, the whole inside out": (joined(turn(sphere(), slice(None)), sphere(1, size=0.3)), 2, 0,
                                       volume(sphere()) - volume(sphere(1, size=0.3)), "faces outward"),
    "loose debris": (joined(sphere(), mesh(np.eye(3) + 5, [[0, 1, 2]])), 2, 1, None, ""),
    "faces with no shared vertices at all": (mesh(np.random.default_rng(2).normal(size=(90, 3)),
                                                  np.arange(90).reshape(-1, 3)), 30, 30, None, ""),
    "far from the origin, very small": (soup(mesh(sphere().V * 1e-6 + 1000, sphere().F)), 1, 0, None, "merged"),
    "huge units": (soup(mesh(sphere().V * 1e12, sphere().F)), 1, 0, volume(sphere()) * 1e36, "merged"),
}


def assert_manifold(m):
    fans = vertex_fans(m.F, opposite_halfedges(m.F), len(m.V))  # raises where an edge is not manifold and oriented
    assert (fans == 1).all()  # no vertex pinched, none unused
    assert inspect(m).problems == ()


@pytest.mark.parametrize("name", DIRTY)
def test_dirty_mesh(name):
    dirty, components, loops, expected_volume, words = DIRTY[name]
    start = time.perf_counter()
    result, report = clean(dirty)
    assert time.perf_counter() - start < 30  # compiling included
    assert_manifold(result)
    counts = topology_of(result.F)
    assert report.after.components == counts.components and report.after.border_loops == counts.border_loops
    assert components in (None, counts.components) and loops in (None, counts.border_loops)
    if expected_volume is not None:
        assert volume(result) == pytest.approx(expected_volume, rel=1e-5, abs=1e-9)
    assert words in report.summary
    assert "\n" not in report.summary and (report.changes == ()) == (words == "")
    if report.changes == ():
        assert result.F is dirty.F and report.summary == "nothing to clean"
    # what is clean stays as it is
    again, second = clean(result)
    assert second.changes == () and (again.F == result.F).all() and (again.V == result.V).all()
    clean(result, "off")
    # no vertex was invented: every vertex lies where one was
    where = {tuple(v) for v in dirty.V.tolist()}
    assert all(tuple(v) in where for v in result.V.tolist())


@pytest.mark.parametrize("name", DIRTY)
def test_off_refuses_exactly_what_does_not_qualify(name):
    dirty = DIRTY[name][0]
    problems = inspect(dirty).problems
    if problems:
        with pytest.raises(MeshError) as caught:
            clean(dirty, "off")
        assert all(p in str(caught.value) for p in problems) and "\n" not in str(caught.value)
    else:
        result, report = clean(dirty, "off")
        assert (result.F == dirty.F).all() and report.summary == "nothing to clean"
        assert_manifold(result)


@given(st.integers(0, 2**31), st.integers(5, 40), st.integers(MIN_FACES, 200), st.booleans())
@settings(max_examples=150, deadline=None)
def test_any_triangles_end_in_a_manifold_or_a_named_error(seed, n, m, grid):
    random = np.random.default_rng(seed)
    V = random.integers(0, 3, (n, 3)) if grid else random.normal(size=(n, 3))
    dirty = mesh(V, random.integers(0, n, (m, 3)))
    try:
        result, report = clean(dirty)
    except MeshError as error:
        assert "Expected" in str(error) and "\n" not in str(error)
    else:
        assert_manifold(result)
        assert clean(result, "off")[1].changes == ()
        again, second = clean(result)  # may find better pairs among faces as tangled as these, never worse ones
        assert_manifold(again)
        assert second.after.border_edges <= report.after.border_edges


@given(st.integers(0, 2**31))
@settings(max_examples=40, deadline=None)
def test_damage_to_a_good_mesh_is_undone(seed):
    random = np.random.default_rng(seed)
    good = box(4)
    F = good.F[random.permutation(len(good.F))]
    F = np.stack([np.roll(f, random.integers(3)) for f in F])
    F = np.where(random.random((len(F), 1)) < random.random() * 0.5, F[:, ::-1], F)
    V = np.concatenate([good.V, random.normal(size=(5, 3))])
    F = np.concatenate([F, F[random.integers(0, len(F), 4)], [[1, 1, 2]]])
    dirty = mesh(V, F)
    if random.random() < 0.5:
        dirty = soup(dirty)
    result, _ = clean(dirty)
    assert_manifold(result)
    counts = topology_of(result.F)
    assert (counts.euler, counts.components, counts.border_loops) == (2, 1, 0)
    assert len(result.F) == len(good.F) and volume(result) == pytest.approx(1)


def test_flat_faces_leave_no_gap_and_move_nothing():
    m = box(3)
    for _ in range(6):
        m = with_cap(m)
    F, mended, kept = remove_flat_faces(m.V, m.F)
    assert (flatness(m.V, F) > FLAT).all() and (mended, kept) == (6, 0) and len(F) == len(m.F)
    assert_manifold(mesh(m.V, F))
    assert volume(mesh(m.V, F)) == pytest.approx(1) and topology_of(F).euler == 2


def strip(n):
    return mesh([[i // 2, i % 2, 0] for i in range(n + 2)], [[i, i + 1, i + 2][::1 - 2 * (i % 2)] for i in range(n)])


REFUSED = {
    "one triangle": (strip(1), "at least 20 faces, found 1"),
    "two triangles": (strip(2), "at least 20 faces, found 2"),
    "nineteen triangles": (strip(19), "at least 20 faces, found 19"),
    "too small after cleaning": (more(strip(6), F=np.tile(strip(6).F, (5, 1))),
                                 "found 6 after cleaning (dropped 30 duplicate faces)"),
    "only repeated corners": (mesh(np.eye(3), [[0, 0, 1]] * 30), "only faces with repeated corners"),
    "all vertices in one point": (mesh(np.zeros((27, 3)), plane(5).F[:18].repeat(2, 0) % 27), "found"),
    "all vertices in a line": (mesh(plane().V * [1, 0, 0], plane().F), "found"),
    "collinear, all distinct": (mesh(plane().V @ [[1, 0, 0], [0.01, 0, 0], [0, 0, 0]], plane().F), "found"),
}


@pytest.mark.parametrize("name", REFUSED)
@pytest.mark.parametrize("mode", ["auto", "off"])
def test_refused(name, mode):
    bad, words = REFUSED[name]
    with pytest.raises(MeshError) as caught:
        clean(bad, mode)
    assert (words in str(caught.value) or mode == "off") and "\n" not in str(caught.value)


def test_twenty_faces_and_a_flat_grid_are_enough():
    assert clean(strip(20))[1].changes == ()
    assert clean(sphere(0))[1].changes == ()
    assert clean(plane())[1].summary == "nothing to clean"


@pytest.mark.parametrize("V, F, words", [
    (np.zeros((0, 3)), np.zeros((0, 3), int), "with vertices, found none"),
    (np.eye(3), np.zeros((0, 3), int), "with faces, found none"),
    (np.eye(3) * np.nan, np.array([[0, 1, 2]]), "NaN"),
    (np.eye(3), np.array([[0, 1, 3]]), "found 0..3"),
])
def test_arrays_that_are_no_mesh_are_named(V, F, words):
    with pytest.raises(MeshError, match=words):
        clean(TriMesh(V, F))


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


def test_the_same_input_gives_the_same_output():
    a, b = clean(DIRTY["Klein bottle"][0])[0], clean(DIRTY["Klein bottle"][0])[0]
    assert (a.F == b.F).all() and (a.V == b.V).all()


@pytest.mark.parametrize("mode", ["auto", "tetwild"])
def test_cancelled(mode):
    if mode == "tetwild":
        pytest.importorskip("pytetwild")

    def cancel(fraction, message):
        raise Cancelled("Cancelled")
    with pytest.raises(Cancelled):
        clean(sphere(), mode, cancel)


def test_progress_rises_to_one_at_most():
    seen = []
    clean(soup(sphere()), progress=lambda fraction, message: seen.append(fraction))
    assert seen == sorted(seen) and 0 <= seen[0] and seen[-1] <= 1 and len(seen) >= 4


def test_tetwild_without_its_package_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pytetwild", None)
    with pytest.raises(DependencyError, match="pip install pytetwild==0.2.3"):
        clean(sphere(), "tetwild")


def test_tetwild_joins_what_overlaps_and_leaves_no_file(tmp_path, monkeypatch):
    pytest.importorskip("pytetwild")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("npm_blender.core.tetwild.ENVELOPE", 1e-2)  # ten times as coarse, for speed
    dirty = joined(sphere(1), mesh(sphere(1, at=(0.9, 0, 0)).V, sphere(1).F[1:]))
    result, report = clean(dirty, "tetwild")
    assert_manifold(result)
    assert "remeshed with TetWild" in report.summary and list(tmp_path.iterdir()) == []
    assert topology_of(result.F).components == 1 and topology_of(result.F).border_loops == 0
    assert volume(sphere()) * 1.3 < volume(result) < volume(sphere()) * 1.8


def test_tetwild_is_ended_after_its_limit():
    pytest.importorskip("pytetwild")
    from npm_blender.core.tetwild import remesh
    with pytest.raises(MeshError, match="within 0 s"):
        remesh(sphere(4).V, sphere(4).F, limit=0.0)


def test_tetwild_on_an_open_sheet_is_named():
    pytest.importorskip("pytetwild")
    with pytest.raises(MeshError, match="TetWild"):
        clean(plane(), "tetwild")
