"""From a mesh as artists have it to an oriented edge- and vertex-manifold, by the least invasive steps that work.

    zero edges and repeated corners -> coincident borders -> duplicate faces -> orientation -> cuts -> flat faces

Every step runs only where the checks find something, and says in one phrase what it did. Open borders and several
components are legal and stay; holes are not filled. Self-intersections are not looked for: they do no harm here, and
'tetwild' removes them.
"""
from dataclasses import dataclass

import numpy as np

from . import repair
from .adjacency import EdgeGroups, corner_parts, face_parts, vertex_parts
from .errors import MeshError
from .flatfaces import remove_flat_faces
from .mesh import TriMesh
from .progress import Progress, no_progress, part
from .tetwild import remesh
from .weld import weld

MIN_FACES = 20  # an icosahedron; a mesh of fewer faces is smaller than anything it could be compressed to


@dataclass(frozen=True)
class MeshReport:
    """What a mesh is like; all are counts.

    vertices, faces: of the arrays. unused_vertices: in no face. coincident_vertices: vertices that lie exactly at an
    earlier used one. repeated_corner_faces: faces that name a vertex twice. zero_area_faces: the others without area.
    duplicate_faces: faces on the three vertices of an earlier one. nonmanifold_edges: edges of more than two faces.
    misoriented_edges: edges of two faces that disagree in direction. pinched_vertices: vertices where surfaces meet in
    a point only. components: parts connected across edges. border_edges, border_loops: of open borders.
    """

    vertices: int
    faces: int
    unused_vertices: int
    coincident_vertices: int
    repeated_corner_faces: int
    zero_area_faces: int
    duplicate_faces: int
    nonmanifold_edges: int
    misoriented_edges: int
    pinched_vertices: int
    components: int
    border_edges: int
    border_loops: int

    @property
    def problems(self) -> tuple[str, ...]:
        """What keeps the mesh from being compressed as it is, one phrase each; empty for an oriented manifold."""
        found = ((self.unused_vertices, "unused vertex", "unused vertices"),
                 (self.repeated_corner_faces, "face with a repeated corner", "faces with repeated corners"),
                 (self.duplicate_faces, "duplicate face", "duplicate faces"),
                 (self.nonmanifold_edges, "edge of more than two faces", "edges of more than two faces"),
                 (self.misoriented_edges, "edge where orientation flips", "edges where orientation flips"),
                 (self.pinched_vertices, "pinched vertex", "pinched vertices"))
        return tuple(_count(n, one, many) for n, one, many in found if n)


@dataclass(frozen=True)
class CleanReport:
    """What `clean` changed. changes: one plain phrase per step, in order; before, after: the mesh's reports."""

    changes: tuple[str, ...]
    before: MeshReport
    after: MeshReport

    @property
    def summary(self) -> str:
        """All changes in one line, or 'nothing to clean'."""
        return "; ".join(self.changes) or "nothing to clean"


def inspect(mesh: TriMesh) -> MeshReport:
    """The report of any mesh, manifold or not. Raises MeshError if its arrays are no mesh (see TriMesh.from_arrays)."""
    mesh = TriMesh.from_arrays(mesh.V, mesh.F)
    V, F, n = mesh.V, mesh.F, len(mesh.V)
    used = np.zeros(n, bool)
    used[F] = True
    broken = repair.repeated_corners(F)
    flat_faces = (repair.flatness(V, F) <= repair.FLAT) & ~broken
    again = repair.duplicates(F) & ~broken
    F = F[~broken & ~again]  # the rest is about the faces that count
    groups = EdgeGroups.of(F, n)
    sizes, first = groups.sizes, groups.halfedges[groups.starts[:-1]]
    flat = F.reshape(-1)
    start, end = flat[first], np.roll(F, -1, 1).reshape(-1)[first]
    second = groups.halfedges[np.minimum(groups.starts[:-1] + 1, max(F.size - 1, 0))]
    border = sizes == 1
    corners = corner_parts(flat, groups.halfedges, groups.starts)
    fans = np.bincount(flat[corners == np.arange(len(flat))], minlength=n)
    loops = vertex_parts(n, start[border], end[border])[start[border]]
    parts = face_parts(len(F), groups.halfedges, groups.starts)
    return MeshReport(
        vertices=n, faces=len(mesh.F), unused_vertices=int((~used).sum()),
        coincident_vertices=int(used.sum()) - len(weld(V[used])[0]),
        repeated_corner_faces=int(broken.sum()), zero_area_faces=int(flat_faces.sum()),
        duplicate_faces=int(again.sum()),
        nonmanifold_edges=int((sizes > 2).sum()), misoriented_edges=int(((sizes == 2) & (start == flat[second])).sum()),
        pinched_vertices=int((fans > 1).sum()), components=int((parts == np.arange(len(F))).sum()),
        border_edges=int(border.sum()), border_loops=len(np.unique(loops)))


def clean(mesh: TriMesh, mode: str = "auto", progress: Progress = no_progress) -> tuple[TriMesh, CleanReport]:
    """An oriented edge- and vertex-manifold without unused vertices, of at least MIN_FACES faces, and what was done.

    mode 'off' changes nothing and raises MeshError naming what does not qualify; 'auto' repairs by the steps of this
    module; 'tetwild' remeshes everything as the surface of a solid first (closes holes, joins what overlaps; minutes
    on large meshes, not deterministic; raises DependencyError without pytetwild). Frame and, but for 'tetwild', vertex
    positions are kept; an unchanged mesh is returned as it came. Raises MeshError for meshes too small or without
    area, Cancelled through `progress`.
    """
    mesh = TriMesh.from_arrays(mesh.V, mesh.F)
    before = inspect(mesh)
    _check_size(before.faces, "")
    progress(0.1, "Checking the mesh")
    if mode == "off":
        if before.problems:
            raise MeshError(f"Expected an oriented manifold, found {', '.join(before.problems)}; "
                            "let it be repaired (--clean auto)")
        _check_area(mesh)
        return mesh, CleanReport((), before, before)
    changes: list[str] = []
    V, F = mesh.V, mesh.F
    if mode == "tetwild":
        _check_area(mesh)
        V, F = remesh(V, F, part(progress, 0.1, 0.9))
        changes.append(f"remeshed with TetWild from {before.faces} to {len(F)} faces")
    V, F = _repair(V, F, changes, part(progress, 0.9 if mode == "tetwild" else 0.1, 1.0))
    _check_size(len(F), f" after cleaning ({'; '.join(changes)})" if changes else "")
    if not changes:
        _check_area(mesh)
        return mesh, CleanReport((), before, before)
    cleaned = TriMesh(np.ascontiguousarray(V), np.ascontiguousarray(F, np.int32))
    _check_area(cleaned)
    after = inspect(cleaned)
    if after.components > before.components:
        changes.append(f"now in {after.components} separate parts")
    return cleaned, CleanReport(tuple(changes), before, after)


def _repair(V: np.ndarray, F: np.ndarray, changes: list[str], progress: Progress) -> tuple[np.ndarray, np.ndarray]:
    """The steps of the module's diagram; appends a phrase to `changes` for each that changed something."""
    loose = len(V) - len(np.unique(F))

    def say(count: int, verb: str, one: str, many: str) -> None:
        if count:
            changes.append(f"{verb} {_count(int(count), one, many)}")

    def drop(F: np.ndarray, bad: np.ndarray, what: str, whats: str) -> np.ndarray:
        say(bad.sum(), "dropped", what, whats)
        if bad.all():
            raise MeshError(f"Expected a surface, found only {whats}; check the mesh")
        return F[~bad] if bad.any() else F

    say(loose, "dropped", "unused vertex", "unused vertices")
    F = drop(F, repair.repeated_corners(F), "face with a repeated corner", "faces with repeated corners")
    groups = EdgeGroups.of(F, len(V))
    F, merged = repair.collapse_zero_edges(V, F, groups)
    if merged:
        say(merged, "collapsed", "edge of zero length", "edges of zero length")
        F = drop(F, repair.repeated_corners(F), "face left without area by that", "faces left without area by that")
        groups = EdgeGroups.of(F, len(V))
    progress(0.2, "Merging vertices")
    F, merged = repair.weld_borders(V, F, groups)
    say(merged, "merged", "duplicate vertex", "duplicate vertices")
    F = drop(F, repair.duplicates(F), "duplicate face", "duplicate faces")
    progress(0.4, "Orienting faces")
    groups = EdgeGroups.of(F, len(V))
    F, turned, outward = repair.orient(V, F, groups)
    say(turned, "turned", "face to agree with its neighbours", "faces to agree with their neighbours")
    if turned or outward:
        groups = EdgeGroups.of(F, len(V))
    progress(0.6, "Cutting non-manifold places")
    steps = len(changes)
    V, F = _cut(V, F, groups, say)
    if (repair.flatness(V, F) <= repair.FLAT).any():
        F, mended, kept = remove_flat_faces(V, F)
        say(mended, "removed", "face without area", "faces without area")
        say(kept, "kept", "face without area that holds the surface together",
            "faces without area that hold the surface together")
        if len(F) == 0:
            raise MeshError("Expected a surface with area, found only faces of zero area; check the mesh")
        V, F = _cut(V, F, EdgeGroups.of(F, len(V)), say)
    if len(changes) > steps:  # what the cuts closed can now be seen from outside
        F, _, again = repair.orient(V, F, EdgeGroups.of(F, len(V)))
        outward += again
    say(outward, "turned", "face outward", "faces outward")
    progress(0.9, "Checking the mesh")
    return repair.compact(V, F)


def _cut(V: np.ndarray, F: np.ndarray, groups: EdgeGroups, say) -> tuple[np.ndarray, np.ndarray]:
    V, F, opened, copies = repair.cut(V, F, groups)
    say(opened, "cut the surface at", "non-manifold edge", "non-manifold edges")
    say(copies, "split off", "vertex where surfaces met", "vertices where surfaces met")
    return V, F


def _count(n: int, one: str, many: str) -> str:
    return f"{n} {one if n == 1 else many}"


def _check_size(faces: int, when: str) -> None:
    if faces < MIN_FACES:
        raise MeshError(f"Expected a mesh of at least {MIN_FACES} faces, found {faces}{when}; "
                        "there is nothing to compress in it, subdivide or join it first")


def _check_area(mesh: TriMesh) -> None:
    extent = float(np.ptp(mesh.V, axis=0).max())
    if not mesh.face_areas().sum() > repair.FLAT * extent * extent or not extent > 0:
        raise MeshError("Expected a surface with area, found all faces in a line or a point; check the mesh's scale")
