"""From a mesh as artists have it to an oriented edge- and vertex-manifold, by the least invasive steps that work.

    zero edges, repeated corners -> parts on other parts -> coincident borders -> T-junctions -> duplicate faces and
    inner walls -> orientation -> cuts -> flat faces

Every step runs only where the checks find something, and says in one phrase what it did. The cuts always end in a
manifold and lose no surface, so 'auto' never needs TetWild, which drops every sheet and takes minutes: it is for those
who ask. What is legal but may surprise is left and named in a note: open borders, faces that pass through others. Holes
are not filled, small ones neither: eyes, sleeves and cut models have them on purpose, a closed one would be surface that
the artist never made, and the codec keeps borders as they are. Cracks without width are closed: no vertex moves for it.
"""
from dataclasses import dataclass

import numpy as np

from ..errors import MeshError
from ..mesh import TriMesh, compact
from ..progress import Progress, no_progress, part
from .border_welding import weld_borders
from .degenerate_faces import FLAT, collapse_zero_edges, flatness, remove_flat_faces, repeated_corners
from .duplicate_faces import doubled_parts, duplicates, inner_walls
from .edge_groups import EdgeGroups
from .inspection import MeshReport, count, inspect
from .manifold_cut import cut
from .orientation import orient
from .self_intersections import crossing_faces
from .t_junctions import close_t_junctions
from .tetwild import remesh

MIN_FACES = 20  # an icosahedron; a mesh of fewer faces is smaller than anything it could be compressed to
SCALE = (1e-60, 1e60)  # units; fourth powers of lengths beyond overflow


@dataclass(frozen=True)
class CleanReport:
    """What `clean` changed and what it left.

    changes: one plain phrase per step, in order; before, after: the mesh's reports; notes: phrases on what is legal,
    was left as it is, and may not be what the artist meant.

    >>> import numpy as np
    >>> from npm_blender.core.cleaning import CleanReport, inspect
    >>> from npm_blender.core.mesh import TriMesh
    >>> report = inspect(TriMesh.from_arrays(np.eye(3), [[0, 1, 2]]))
    >>> CleanReport(("merged 2 duplicate vertices",), report, report, ("left 1 border open",)).summary
    'merged 2 duplicate vertices; left 1 border open'
    """

    changes: tuple[str, ...]
    before: MeshReport
    after: MeshReport
    notes: tuple[str, ...] = ()

    @property
    def summary(self) -> str:
        """All changes, or 'nothing to clean', and the notes, in one line."""
        return "; ".join(((*self.changes,) or ("nothing to clean",)) + self.notes)


def clean(mesh: TriMesh, mode: str = "auto", progress: Progress = no_progress) -> tuple[TriMesh, CleanReport]:
    """An oriented edge- and vertex-manifold without unused vertices, of at least MIN_FACES faces, and what was done.

    mode 'off' changes nothing and raises MeshError naming what does not qualify; 'auto' repairs by the steps of this
    module what the checks find; 'tetwild' remeshes everything as the surface of a solid first (closes holes, joins what
    overlaps, drops sheets; minutes on large meshes; kept in the user's cache, because it is not deterministic; raises
    DependencyError without pytetwild). Frame and, but for 'tetwild', vertex positions are kept; an unchanged mesh is
    returned as it came. Raises MeshError for meshes too small, without area or of an extent beyond SCALE, Cancelled
    through `progress`. The cuts are those of Gueziec et al. (2001); what decides on the other steps is ours.

    >>> import numpy as np
    >>> from npm_blender.core.cleaning import clean
    >>> from npm_blender.core.mesh import TriMesh
    >>> x, y = np.meshgrid(np.arange(5.0), np.arange(5.0))
    >>> i = np.arange(20)[np.arange(20) % 5 < 4]  # lower left corners of 16 squares
    >>> F = np.concatenate([np.stack([i, i + 1, i + 6], 1), np.stack([i, i + 5, i + 6], 1)])  # every second face flipped
    >>> mesh, report = clean(TriMesh.from_arrays(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1), F))
    >>> report.summary
    'turned 16 faces to agree with their neighbours; left 1 border open'
    """
    mesh = TriMesh.from_arrays(mesh.V, mesh.F)
    _check_scale(mesh.V)
    before = inspect(mesh, part(progress, 0.0, 0.2))
    _check_size(before.faces, "")
    if mode == "off":
        if before.problems:
            raise MeshError(f"Expected an oriented manifold, found {', '.join(before.problems)}; "
                            "let it be repaired (--clean auto)")
        _check_area(mesh)
        return mesh, CleanReport((), before, before, _notes(mesh, before, progress))
    changes: list[str] = []
    V, F = mesh.V, mesh.F
    if mode == "tetwild":
        _check_area(mesh)
        V, F, known = remesh(*compact(V, F), part(progress, 0.2, 0.8))
        again = ", the result of an earlier run" if known else ""
        changes.append(f"remeshed with TetWild from {before.faces} to {len(F)} faces{again}")
    V, F = _repair(V, F, changes, part(progress, 0.8 if mode == "tetwild" else 0.2, 0.9))
    _check_size(len(F), f" after cleaning ({'; '.join(changes)})" if changes else "")
    cleaned = TriMesh(np.ascontiguousarray(V), np.ascontiguousarray(F, np.int32)) if changes else mesh
    _check_area(cleaned)
    after = inspect(cleaned, part(progress, 0.9, 0.96)) if changes else before
    if after.components > before.components:
        changes.append(f"now in {after.components} separate parts")
    return cleaned, CleanReport(tuple(changes), before, after, _notes(cleaned, after, progress))


def _notes(mesh: TriMesh, report: MeshReport, progress: Progress) -> tuple[str, ...]:
    """What was left as it is, one phrase each."""
    progress(0.96, "Checking the mesh")
    notes = []
    if report.border_loops:
        notes.append(f"left {count(report.border_loops, 'border', 'borders')} open")
    crossing, exact = crossing_faces(mesh.V, mesh.F, part(progress, 0.96, 1.0))
    if crossing:
        notes.append(f"left {'' if exact else 'about '}{count(crossing, 'face that passes', 'faces that pass')} "
                     "through others")
    progress(1.0, "Checking the mesh")
    return tuple(notes)


def _repair(V: np.ndarray, F: np.ndarray, changes: list[str], progress: Progress) -> tuple[np.ndarray, np.ndarray]:
    """The steps of the module's diagram; appends a phrase to `changes` for each that changed something."""
    loose = len(V)
    V, F = compact(V, F)
    _say(changes, "dropped", loose - len(V), "unused vertex", "unused vertices")
    groups = _close_cracks(V, F, changes, progress)
    progress(0.5, "Orienting faces")
    F = _drop(changes, groups.F, inner_walls(groups.F), "face of an inner wall", "faces of inner walls")
    F = _drop(changes, F, duplicates(F), "duplicate face", "duplicate faces")
    V, F = _make_manifold(V, groups.replaced(F), changes, progress)
    progress(1.0, "Checking the mesh")
    return compact(V, F)


def _close_cracks(V: np.ndarray, F: np.ndarray, changes: list[str], progress: Progress) -> EdgeGroups:
    """The first row of the diagram: zero edges to T-junctions. Vertices become one or stay; none moves."""
    F = _drop(changes, F, repeated_corners(F), "face with a repeated corner", "faces with repeated corners")
    groups = EdgeGroups.of(F, len(V))
    progress(0.1, "Merging vertices")
    F, merged = collapse_zero_edges(V, groups)
    if merged:
        _say(changes, "collapsed", merged, "edge of zero length", "edges of zero length")
        F = _drop(changes, F, repeated_corners(F), "face left without area by that", "faces left without area by that")
    groups = groups.replaced(F)
    F = _drop(changes, F, doubled_parts(V, groups), "face of a part that lies on another", "faces of parts that lie on others")
    groups, merged = weld_borders(V, groups.replaced(F), part(progress, 0.1, 0.3))
    _say(changes, "merged", merged, "duplicate vertex", "duplicate vertices")
    groups, splits = close_t_junctions(V, groups, part(progress, 0.3, 0.5))
    _say(changes, "closed", splits, "T-junction", "T-junctions")
    return groups


def _make_manifold(V: np.ndarray, groups: EdgeGroups, changes: list[str],
                   progress: Progress) -> tuple[np.ndarray, np.ndarray]:
    """The last row of the diagram: orientation, cuts, flat faces."""
    progress(0.6, "Orienting faces")
    F, flipped, outward = orient(V, groups)
    _say(changes, "turned", flipped, "face to agree with its neighbours", "faces to agree with their neighbours")
    progress(0.7, "Cutting non-manifold places")
    steps = len(changes)
    V, F = _cut(V, groups.replaced(F), changes)
    progress(0.8, "Cutting non-manifold places")
    if (flatness(V, F) <= FLAT).any():
        F, mended, left = remove_flat_faces(V, F)
        _say(changes, "removed", mended, "face without area", "faces without area")
        _say(changes, "kept", left, "face without area that holds the surface together",
             "faces without area that hold the surface together")
        if len(F) == 0:
            raise MeshError("Expected a surface with area, found only faces of zero area; check the mesh")
        V, F = _cut(V, EdgeGroups.of(F, len(V)), changes)
    if len(changes) > steps:  # what the cuts closed can now be seen from outside
        progress(0.9, "Orienting faces")
        F, _, again = orient(V, EdgeGroups.of(F, len(V)))
        outward += again
    _say(changes, "turned", outward, "face outward", "faces outward")
    return V, F


def _cut(V: np.ndarray, groups: EdgeGroups, changes: list[str]) -> tuple[np.ndarray, np.ndarray]:
    V, F, opened, copies = cut(V, groups)
    _say(changes, "cut the surface at", opened, "non-manifold edge", "non-manifold edges")
    _say(changes, "split off", copies, "vertex where surfaces met", "vertices where surfaces met")
    return V, F


def _say(changes: list[str], verb: str, number: int, one: str, many: str) -> None:
    """Append the phrase '<verb> <number> <things>', where there are any."""
    if number:
        changes.append(f"{verb} {count(int(number), one, many)}")


def _drop(changes: list[str], F: np.ndarray, bad: np.ndarray, one: str, many: str) -> np.ndarray:
    """F (m, 3) without the faces `bad` (m,) bool; the very array F where none is."""
    _say(changes, "dropped", bad.sum(), one, many)
    if bad.all():
        raise MeshError(f"Expected a surface, found only {many}; check the mesh")
    return F[~bad] if bad.any() else F


def _check_size(faces: int, when: str) -> None:
    if faces < MIN_FACES:
        raise MeshError(f"Expected a mesh of at least {MIN_FACES} faces, found {faces}{when}; "
                        "there is nothing to compress in it, subdivide or join it first")


def _check_scale(V: np.ndarray) -> None:
    extent = float(np.ptp(V / 2, axis=0).max()) * 2
    if extent and not SCALE[0] <= extent <= SCALE[1]:
        raise MeshError(f"Expected an extent from {SCALE[0]:.0e} to {SCALE[1]:.0e} units, found {extent:.0e}; "
                        "scale the mesh, or look for a stray vertex")


def _check_area(mesh: TriMesh) -> None:
    if not (flatness(mesh.V, mesh.F) > FLAT).any():
        raise MeshError("Expected a surface with area, found all faces in a line or a point; check the mesh's scale")
