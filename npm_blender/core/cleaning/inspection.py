"""What a mesh is like: the counts that decide what `clean` has to do."""
from dataclasses import dataclass

import numpy as np

from ..geometry import weld
from ..mesh import TriMesh, next_halfedges
from ..progress import Progress, no_progress
from .degenerate_faces import FLAT, flatness, repeated_corners
from .duplicate_faces import duplicates
from .edge_groups import EdgeGroups, corner_parts, face_parts, vertex_parts


@dataclass(frozen=True)
class MeshReport:
    """What a mesh is like; all are counts.

    vertices, faces: of the arrays. unused_vertices: in no face. coincident_vertices: vertices that lie exactly at an
    earlier used one. repeated_corner_faces: faces that name a vertex twice. zero_area_faces: the others without area.
    duplicate_faces: faces on the three vertices of an earlier one. nonmanifold_edges: edges of more than two faces.
    misoriented_edges: edges of two faces that disagree in direction. pinched_vertices: vertices where surfaces meet in
    a point only. components: parts connected across edges. border_edges, border_loops: of open borders.

    >>> import numpy as np
    >>> from npm_blender.core.cleaning import inspect
    >>> from npm_blender.core.mesh import TriMesh
    >>> book = TriMesh.from_arrays(np.eye(5, 3), [[0, 1, 2], [1, 0, 3], [0, 1, 4]])  # three faces at one edge
    >>> inspect(book).problems
    ('1 edge of more than two faces',)
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
        return tuple(count(n, one, many) for n, one, many in found if n)


def count(n: int, one: str, many: str) -> str:
    """'1 face', '2 faces'."""
    return f"{n} {one if n == 1 else many}"


def inspect(mesh: TriMesh, progress: Progress = no_progress) -> MeshReport:
    """The report of any mesh, manifold or not.

    Raises MeshError if its arrays are no mesh (see TriMesh.from_arrays), and whatever `progress` raises.

    >>> import numpy as np
    >>> from npm_blender.core.cleaning import inspect
    >>> from npm_blender.core.mesh import TriMesh
    >>> report = inspect(TriMesh.from_arrays(np.eye(4, 3), [[0, 1, 2], [0, 2, 2]]))
    >>> report.unused_vertices, report.repeated_corner_faces, report.border_edges
    (1, 1, 3)
    """
    what = "Checking the mesh"
    mesh = TriMesh.from_arrays(mesh.V, mesh.F)
    V, F, n = mesh.V, mesh.F, len(mesh.V)
    used = np.zeros(n, bool)
    used[F] = True
    broken = repeated_corners(F)
    flat_faces = (flatness(V, F) <= FLAT) & ~broken
    progress(0.1, what)
    again = duplicates(F) & ~broken
    progress(0.25, what)
    F = F[~broken & ~again]  # the rest is about the faces that count
    groups = EdgeGroups.of(F, n)
    progress(0.5, what)
    sizes, first = groups.sizes, groups.halfedges[groups.starts[:-1]]
    flat = F.reshape(-1)
    start, end = flat[first], flat[next_halfedges(first)]
    second = groups.halfedges[np.minimum(groups.starts[:-1] + 1, max(F.size - 1, 0))]
    border = sizes == 1
    corners = corner_parts(flat, groups.halfedges, groups.starts)
    fans = np.bincount(flat[corners == np.arange(len(flat))], minlength=n)
    progress(0.75, what)
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
