"""QEM edge collapse to a base mesh (Garland and Heckbert 1997), recording the successive self-parameterization.

Every collapse keeps the topology (link condition), may not flip a face or ruin its shape, and must have a bijective
flattening (see `flatten_jointly`); so the base has the Euler characteristic, components and border loops of the input, and the
map between them is a bijection by construction. A collapse that fails the tests of shape is offered again under milder
ones at a higher price: where little is admissible, a poor triangle is better than a wall pulled through the part. An open
border keeps the edges that its corners need (see `borderedges`), as long as the number of faces can be reached with them.
"""
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..mesh import TriMesh
from ..parameterization import CollapseRecord, SurfaceMap
from ..progress import Progress, no_progress, part, rising
from ..settings import AUTO
from .collapse_loop import DONE, EMPTY, Scratch, Tests
from .decimator import Decimator
from .face_bounds import roomier
from .halfedge_mesh import HalfedgeMesh
from .regions import decimate_regions, worth_dividing

FEWEST, MOST = 100, 2000  # base faces that are chosen from the shape
DEAR = 4e-7  # price (squared distance times area, unit frame) of a collapse that such a base leaves out
SLICE = 2000  # collapses between two calls of `progress`
LEFT_SHARE = 0.2  # of the faces, left by the regions (see `regions`): an estimate, for the progress bar
STALLED = 0.9  # of the faces left after a round over the regions: no further round is worth its time
MESSAGE = "Decimating"


class AdmissibilityTest(NamedTuple):
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
    AdmissibilityTest(1.0, 0.2, 0.01, 20.0),
    AdmissibilityTest(8.0, 0.1, 0.003, 1000.0),
    AdmissibilityTest(64.0, -0.5, 0.0, np.inf),
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
    history: CollapseRecord
    opposite: np.ndarray
    message: str = ""

    @property
    def surface_map(self) -> SurfaceMap:
        """The bijection between base and input."""
        return SurfaceMap(self.history, self.faces, len(self.mesh.F))


def decimate(mesh: TriMesh, base_faces: int, variant: int = 0, progress: Progress = no_progress,
             room: bool = True) -> Decimation:
    """Collapse the edges of an oriented manifold mesh, in the unit frame, down to base_faces faces.

    base_faces AUTO: as many as the shape needs, FEWEST to MOST; from MOST on, the collapses end at the first that would
    cost more than DEAR, so a smooth shape gets few faces and a shape full of detail, handles or parts gets many.
    A number that can be reached is obeyed. Where the parts or handles of the mesh need more, the base gets as many as show
    them (see `leastfaces.roomier`); without `room` handles get as few as they can do with.
    variant 0 takes the cheapest edge; k > 0 a random one among about 100 cheapest, seeded by k. A closed mesh has an
    even number of faces, so an odd target gives one face less; so does a target whose last single face is one that the border
    needs. A large mesh is decimated by its regions first, side by side
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
    tests = Tests(*(np.array(column, np.float64) for column in zip(*STAGES, strict=True)))
    work = Decimator.of(mesh, tests, enough or base_faces, variant)
    opposite = work.half.opposite.copy()
    total, most, faces = work.faces, max(base_faces, enough), np.inf

    def share(faces: float) -> float:
        return (total - faces) / max(total - base_faces, 1)

    while worth_dividing(work.faces, most) and work.faces < STALLED * faces:
        faces = work.faces
        decimate_regions(work, most, dear, part(progress, share(faces), share(LEFT_SHARE * faces)), MESSAGE)
    work.offer_all()
    scratch, before = Scratch.make(), work.counts[2]
    while work.faces > base_faces:
        reason = work.run(scratch, base_faces, SLICE, enough, dear)
        progress(share(work.faces), MESSAGE)
        if reason == DONE:
            break
        if reason == EMPTY:
            if work.counts[2] == before:
                if work.counts[6] and work.faces == base_faces + 1:
                    work.counts[6] = 0  # rather a face less than a border that is cut short
                elif not (work.faces > enough and work.corners.yield_to()):
                    break
            before = work.counts[2]
            work.offer_all()
    return _result(mesh, work.half, work.history.used(work.counts), opposite, work.faces if enough else base_faces)


def _result(mesh: TriMesh, half: HalfedgeMesh, history: CollapseRecord, opposite: np.ndarray, target: int) -> Decimation:
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
