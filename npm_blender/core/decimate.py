"""QEM edge collapse to a base mesh (Garland and Heckbert 1997), recording the successive self-parameterization.

Every collapse keeps the topology (link condition), may not flip a face or ruin its shape, and must have a bijective
flattening (see `flatten`); so the base has the Euler characteristic, components and border loops of the input, and the
map between them is a bijection by construction. A collapse that fails the tests of shape is offered again under milder
ones at a higher price: where little is admissible, a poor triangle is better than a wall pulled through the part. An open
border keeps the edges that its corners need (see `borderedges`), as long as the number of faces can be reached with them.
"""
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from .borderedges import Corners
from .collapses import DONE, EMPTY, LEAST, Queue, Scratch, Tests, run
from .edgeheap import DEAD, REJECTED, heapify
from .errors import MeshError
from .halfedge import Half, connect
from .history import History
from .leastfaces import roomier
from .mesh import TriMesh
from .progress import Progress, no_progress, part, rising
from .quadric import edge_costs, vertex_quadrics
from .regions import decimate_regions, worth_dividing
from .settings import AUTO
from .topology import opposite_halfedges

FEWEST, MOST = 100, 2000  # base faces that are chosen from the shape
DEAR = 4e-7  # price (squared distance times area, unit frame) of a collapse that such a base leaves out
SLICE = 2000  # collapses between two calls of `progress`
LEFT_SHARE = 0.2  # of the faces, left by the regions (see `regions`): an estimate, for the progress bar
STALLED = 0.9  # of the faces left after a round over the regions: no further round is worth its time
MESSAGE = "Decimating"


class Stage(NamedTuple):
    """Tests of a collapse.

    price: factor on the quadric error when the queue orders collapses; cosine: least cosine between a face's normal
    before and after; quality: least face quality 4 sqrt(3) A / sum l^2 (or that of the patch before, if lower); stretch:
    largest distortion of the conformal flattening, past which the one on a circle takes its place.
    """

    price: float
    cosine: float
    quality: float
    stretch: float


STAGES = (
    Stage(1.0, 0.2, 0.01, 20.0),
    Stage(8.0, 0.1, 0.003, 1000.0),
    Stage(64.0, -0.5, 0.0, np.inf),
)


@dataclass(frozen=True)
class Decimation:
    """A base mesh and the map between it and the input mesh.

    mesh: the input; V0 (n0, 3) float64 and F0 (m0, 3) int32: the base; vertices (n0,) and faces (m0,) int32: the input
    vertex and face whose place each base vertex and face took (a base face f is reached in `history` as faces[f], with
    the corners in the same order); history: the collapses; opposite (3 m,) int32: opposite half-edges of the input;
    message: '' or one line on what could not be reached.
    """

    mesh: TriMesh
    V0: np.ndarray
    F0: np.ndarray
    vertices: np.ndarray
    faces: np.ndarray
    history: History
    opposite: np.ndarray
    message: str = ""


def half_edges(mesh: TriMesh) -> Half:
    """The half-edge form of a mesh. Raises MeshError if it is not an oriented edge- and vertex-manifold."""
    opposite = opposite_halfedges(mesh.F)
    corner = mesh.F.reshape(-1).copy()
    edge, start, out, valence, pinched = connect(corner, opposite, len(mesh.V))
    if pinched:
        raise MeshError(f"Expected a manifold mesh, found {pinched} vertices where separate fans of faces meet; "
                        "clean the mesh first (--clean auto)")
    return Half(mesh.V.copy(), corner, opposite, edge, out, valence, start, np.zeros(len(mesh.V), np.int64))


def _requeue(queue: Queue) -> int:
    """Put the rejected and the locked edges back, for the first tests; returns the number of edges in the queue."""
    again = np.flatnonzero(queue.place != DEAD).astype(np.int32)
    queue.heap[:len(again)] = again
    queue.stage[again] = 0
    queue.price[again] = STAGES[0].price * (queue.error[again] + LEAST)
    heapify(queue.heap, queue.place, queue.price, len(again))
    return len(again)


def decimate(mesh: TriMesh, base_faces: int, variant: int = 0, progress: Progress = no_progress,
             room: bool = True) -> Decimation:
    """Collapse the edges of an oriented manifold mesh, in the unit frame, down to base_faces faces.

    base_faces AUTO: as many as the shape needs, FEWEST to MOST; from MOST on, the collapses end at the first that would
    cost more than DEAR, so a smooth shape gets few faces and a shape full of detail, handles or parts gets many.
    A number that can be reached is obeyed. Where the parts or handles of the mesh need more, the base gets as many as show
    them (see `leastfaces.roomier`); without `room` handles get as few as they can do with.
    variant 0 takes the cheapest edge; k > 0 a random one among about 100 cheapest, seeded by k. A closed mesh has an
    even number of faces, so an odd target gives one face less. A large mesh is decimated by its regions first, side by side
    (see `regions`). Deterministic, whatever the number of threads. Raises MeshError if the mesh is not an
    oriented manifold, and whatever `progress` raises.
    """
    progress = rising(progress)  # where parts or handles ask for a second run, too
    out = _collapse(mesh, base_faces, variant, progress)
    faces, why = roomier(out.F0, base_faces, len(mesh.F) // 2 if room else 0)
    if faces:
        out = replace(_collapse(mesh, faces, variant, progress), message="")
    return replace(out, message=f"Reached {len(out.F0)} of {base_faces} base faces: {why}") if why else out


def _collapse(mesh: TriMesh, base_faces: int, variant: int, progress: Progress) -> Decimation:
    """All collapses, as `decimate` describes them, to a number of faces or AUTO."""
    progress(0.0, MESSAGE)
    enough, dear = (MOST, DEAR) if base_faces == AUTO else (0, np.inf)
    base_faces = FEWEST if base_faces == AUTO else base_faces
    half = half_edges(mesh)
    total, edges = len(mesh.F), len(half.start)
    opposite = half.opposite.copy()
    quadrics = vertex_quadrics(half.X, half.corner, half.opposite)
    error = edge_costs(quadrics, half.X, half.corner, half.start)
    queue = Queue(np.arange(edges, dtype=np.int32), np.full(edges, REJECTED, np.int32), np.empty(edges), error,
                  np.zeros(edges, np.int8), np.zeros(len(mesh.V), bool))
    tests = Tests(*(np.array(column, np.float64) for column in zip(*STAGES, strict=True)))
    history = History.empty(total)
    scratch = Scratch.make()
    corners = Corners.of(half, enough or base_faces)
    counts = np.array([total, edges, 0, 0, 0, 0, variant, 0], np.int64)  # see `run`
    counts[7] = (opposite == np.arange(len(opposite))).any()
    most, faces = max(base_faces, enough), np.inf

    def share(faces: float) -> float:
        return (total - faces) / max(total - base_faces, 1)

    while worth_dividing(counts[0], most) and counts[0] < STALLED * faces:
        faces = int(counts[0])
        ahead = part(progress, share(faces), share(LEFT_SHARE * faces))
        history = decimate_regions(half, quadrics, queue, corners, history, counts, tests, most, dear, ahead, MESSAGE)
    counts[1] = _requeue(queue)
    before = counts[2]
    while counts[0] > base_faces:
        history = history.with_room(counts, (int(counts[0]) - base_faces) // 2 + 1)
        reason = run(half, quadrics, queue, corners, history, scratch, counts, base_faces, SLICE, tests, enough, dear)
        progress(share(counts[0]), MESSAGE)
        if reason == DONE:
            break
        if reason == EMPTY:
            if counts[2] == before and not (counts[0] > enough and corners.yield_to()):
                if not counts[7] or counts[0] != base_faces + 1:
                    break
                counts[7] = 0
            before = counts[2]
            counts[1] = _requeue(queue)
    if enough:
        base_faces = int(counts[0])
    return _result(mesh, half, history.used(counts), opposite, base_faces)


def _result(mesh: TriMesh, half: Half, history: History, opposite: np.ndarray, target: int) -> Decimation:
    corner = half.corner.reshape(-1, 3)
    faces = np.flatnonzero(corner[:, 0] >= 0).astype(np.int32)
    vertices, F0 = np.unique(corner[faces], return_inverse=True)
    found = len(faces)
    reason = "no further collapse keeps topology and shape" if found > target else "no collapse removes a single face"
    if len(mesh.F) < target:
        reason = "the mesh has no more"
    elif found < target and not (opposite == np.arange(len(opposite))).any():
        reason = "a closed mesh has an even number"
    message = "" if found == target else f"Reached {found} of {target} base faces: {reason}"
    F0 = np.ascontiguousarray(F0.reshape(-1, 3), dtype=np.int32)
    return Decimation(mesh, half.X[vertices], F0, vertices.astype(np.int32), faces, history, opposite, message)
