"""A mesh while its edges are collapsed: all arrays of the loop in `collapse_loop`, for the whole mesh or a region of it."""
from dataclasses import dataclass

import numpy as np

from ..errors import MeshError
from ..mesh import TriMesh, opposite_halfedges
from ..parallel import together
from ..parameterization import CollapseRecord
from .admissibility import TestColumns
from .border_corners import Corners
from .collapse_loop import FACES_LEFT, HAS_BORDER, QUEUED, RANDOM, SINGLE, Limits, Scratch, run_collapses
from .edge_heap import DEAD, REJECTED
from .edge_queue import Queue, offer
from .halfedge_mesh import HalfedgeMesh, connect_halfedges, opposites
from .quadric import edge_costs, vertex_quadrics


def half_edges_with_quadrics(mesh: TriMesh) -> tuple[HalfedgeMesh, np.ndarray]:
    """The half-edge form of a mesh, and the quadrics (n, 10) float64 of its vertices (Garland and Heckbert 1997).

    A quadric is the sum of the squared distances to the planes of the faces at the vertex, weighted by their areas, and on
    the border to planes through its edges: E(x) = x'Ax + 2 b'x + c, kept as (xx, xy, xz, yy, yz, zz) of A, b and c.
    Raises MeshError if the mesh is not an oriented edge- and vertex-manifold.

    >>> from npm_blender.core.decimation import half_edges_with_quadrics
    >>> from npm_blender.core.mesh import TriMesh
    >>> V = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> tetrahedron = TriMesh.from_arrays(V, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    >>> halfedges, quadrics = half_edges_with_quadrics(tetrahedron)
    >>> quadrics[0].tolist()  # vertex 0 lies on three planes x = 0, y = 0 and z = 0, with faces of area 1/2 each
    [0.5, 0.0, 0.0, 0.5, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0]
    """
    corner = mesh.F.reshape(-1).copy()
    opposite, oriented = opposites(corner, len(mesh.V))
    if not oriented:
        opposite = opposite_halfedges(mesh.F)  # raises, and says how many edges are wrong
    (edge, start, out, valence, pinched), quadrics = together(
        lambda: connect_halfedges(corner, opposite, len(mesh.V)), lambda: vertex_quadrics(mesh.V, corner, opposite))
    if pinched:
        raise MeshError(f"Expected a manifold mesh, found {pinched} vertices where separate fans of faces meet; "
                        "clean the mesh first (--clean auto)")
    return HalfedgeMesh(mesh.V.copy(), corner, opposite, edge, out, valence, start), quadrics


def fresh_counts(faces: int, variant: int, border: bool) -> np.ndarray:
    """`counts` of `collapse_loop` for a mesh of so many faces, no edge in the queue; variant: the random state."""
    counts = np.zeros(4, np.int64)
    counts[FACES_LEFT], counts[RANDOM], counts[HAS_BORDER] = faces, variant, border
    return counts


@dataclass
class Decimator:
    """A decimation under way.

    mesh: as it is now; quadrics (n, 10) of its vertices; queue: its edges; corners: of its border; tests: what a collapse has
    to pass; counts (4,) int64: see `collapse_loop`; record: the collapses so far; dearest: the highest price that was paid.
    """

    mesh: HalfedgeMesh
    quadrics: np.ndarray
    queue: Queue
    corners: Corners
    tests: TestColumns
    counts: np.ndarray
    record: CollapseRecord
    dearest: float = 0.0

    @staticmethod
    def of(mesh: TriMesh, tests: TestColumns, base_faces: int, variant: int) -> "Decimator":
        """A mesh of which nothing has collapsed yet; no edge is in the queue. Raises MeshError as `half_edges_with_quadrics`.

        base_faces: those that the corners of the border are to be content with; variant: see `decimate`.
        """
        halfedges, quadrics = half_edges_with_quadrics(mesh)
        edges = len(halfedges.start)
        error = edge_costs(quadrics, halfedges.X, halfedges.corner, halfedges.start)
        queue = Queue(np.arange(edges, dtype=np.int32), np.empty(edges), np.full(edges, REJECTED, np.int32), error,
                      np.zeros(edges, np.int8), np.zeros(len(mesh.V), bool))
        border = (halfedges.opposite == np.arange(len(halfedges.opposite))).any()
        return Decimator(halfedges, quadrics, queue, Corners.of(halfedges, base_faces), tests,
                         fresh_counts(len(mesh.F), variant, border), CollapseRecord.empty())

    @property
    def faces(self) -> int:
        """Faces that are left."""
        return int(self.counts[FACES_LEFT])

    def offer(self, edges: np.ndarray) -> None:
        """Make these edges the queue, for the first test."""
        offer(self.queue, self.tests, edges)
        self.counts[QUEUED] = len(edges)

    def offer_all(self) -> None:
        """Make all edges the queue, rejected and locked ones too."""
        self.offer(np.flatnonzero(self.queue.place != DEAD).astype(np.int32))

    def run(self, scratch: Scratch, limits: Limits) -> int:
        """`collapse_loop.run_collapses`, with room for its record: DONE, EMPTY or MORE."""
        self.record = self.record.with_room(max(self.faces - limits.target, 0) // 2 + 1)
        limits = limits._replace(single=SINGLE * self.dearest)
        status, price = run_collapses(self.mesh, self.quadrics, self.queue, self.corners, self.record, scratch, self.counts,
                                      self.tests, limits)
        self.dearest = max(self.dearest, price)
        return status
