"""A mesh while its edges are collapsed: all arrays of the loop in `collapses`, for the whole mesh or a region of it."""
from dataclasses import dataclass

import numpy as np

from ..errors import MeshError
from ..mesh import TriMesh, opposite_halfedges
from ..parallel import together
from ..parameterization import CollapseRecord
from .border_corners import Corners
from .collapse_loop import Queue, Scratch, Tests, offer, run_collapses
from .edge_heap import DEAD, REJECTED
from .halfedge_mesh import HalfedgeMesh, connect_halfedges, opposites
from .quadric import edge_costs, vertex_quadrics


def half_edges_with_quadrics(mesh: TriMesh) -> tuple[HalfedgeMesh, np.ndarray]:
    """The half-edge form of a mesh, and the quadrics (n, 10) of its vertices.

    Raises MeshError if the mesh is not an oriented edge- and vertex-manifold.
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


@dataclass
class Decimator:
    """A decimation under way.

    half: the mesh as it is now; quadrics (n, 10) of its vertices; queue: its edges; corners: of its border; tests: what a
    collapse has to pass; counts (7,) int64: see `collapses.run_collapses`; history: the collapses so far.
    """

    half: HalfedgeMesh
    quadrics: np.ndarray
    queue: Queue
    corners: Corners
    tests: Tests
    counts: np.ndarray
    history: CollapseRecord

    @staticmethod
    def of(mesh: TriMesh, tests: Tests, base_faces: int, variant: int) -> "Decimator":
        """A mesh of which nothing has collapsed yet; no edge is in the queue. Raises MeshError as `half_edges_with_quadrics`.

        base_faces: those that the corners of the border are to be content with; variant: see `decimate`.
        """
        half, quadrics = half_edges_with_quadrics(mesh)
        edges = len(half.start)
        error = edge_costs(quadrics, half.X, half.corner, half.start)
        queue = Queue(np.arange(edges, dtype=np.int32), np.empty(edges), np.full(edges, REJECTED, np.int32), error,
                      np.zeros(edges, np.int8), np.zeros(len(mesh.V), bool))
        border = (half.opposite == np.arange(len(half.opposite))).any()
        counts = np.array([len(mesh.F), 0, 0, 0, 0, variant, border], np.int64)
        return Decimator(half, quadrics, queue, Corners.of(half, base_faces), tests, counts, CollapseRecord.empty())

    @property
    def faces(self) -> int:
        """Faces that are left."""
        return int(self.counts[0])

    def offer(self, edges: np.ndarray) -> None:
        """Make these edges the queue, for the first tests."""
        offer(self.queue, self.tests, edges)
        self.counts[1] = len(edges)

    def offer_all(self) -> None:
        """Make all edges the queue, rejected and locked ones too."""
        self.offer(np.flatnonzero(self.queue.place != DEAD).astype(np.int32))

    def run(self, scratch: Scratch, target: int, collapses: int, enough: int = 0, dear: float = np.inf) -> int:
        """`collapses.run_collapses`, with room for its history: DONE, EMPTY or MORE."""
        self.history = self.history.with_room(self.counts, max(self.faces - target, 0) // 2 + 1)
        return run_collapses(self.half, self.quadrics, self.queue, self.corners, self.history, scratch, self.counts, target,
                             collapses, self.tests, enough, dear)
