"""QEM edge collapse to a base mesh (Garland and Heckbert 1997), recording the successive self-parameterization.

Every collapse keeps the topology (link condition), may not flip a face or ruin its shape, and must have a bijective
flattening (see `flatten_jointly`); so the base has the Euler characteristic, components and border loops of the input, and the
map between them is a bijection by construction. A collapse that fails the tests of shape is offered again under milder
ones at a higher price: where little is admissible, a poor triangle is better than a wall pulled through the part. An open
border keeps the edges that its corners need (see `border_corners`), as long as the number of faces can be reached with them.
"""
from dataclasses import dataclass, replace

import numpy as np

from ..mesh import TriMesh
from ..parameterization import CollapseRecord, SurfaceMap
from ..progress import Progress, no_progress, part, rising
from ..settings import AUTO
from .admissibility import ADMISSIBILITY_TESTS, TestColumns
from .base_message import base_message
from .collapse_loop import DONE, EMPTY, HAS_BORDER, Limits, Scratch
from .decimator import Decimator
from .face_bounds import Cause, FaceAdvice, face_advice
from .regions import decimate_regions, worth_dividing

FEWEST, MOST = 100, 2000  # base faces that are chosen from the shape
DEAR = 4e-7  # price (squared distance times area, unit frame) of a collapse that such a base leaves out
SLICE = 2000  # collapses between two calls of `progress`
LEFT_SHARE = 0.2  # of the faces, left by the regions (see `regions`): an estimate, for the progress bar
STALLED = 0.9  # of the faces left after a round over the regions: no further round is worth its time
MESSAGE = "Decimating"


@dataclass(frozen=True)
class Decimation:
    """A base mesh and the map between it and the input mesh.

    mesh: the input; V0 (n0, 3) float64 and F0 (m0, 3) int32: the base; vertices (n0,) and faces (m0,) int32: the input
    vertex and face whose place each base vertex and face took (a base face f is reached in `record` as faces[f], with
    the corners in the same order); record: the collapses; opposite (3 m,) int32: opposite half-edges of the input;
    asked: the number of base faces that was asked for; advice: why the base has another one.

    >>> from npm_blender.core.decimation import decimate
    >>> from npm_blender.core.mesh import TriMesh
    >>> base = decimate(TriMesh.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), 4)
    >>> len(base.F0), base.faces.tolist(), base.message
    (1, [0], 'Reached 1 of 4 base faces: the mesh has no more')
    """

    mesh: TriMesh
    V0: np.ndarray
    F0: np.ndarray
    vertices: np.ndarray
    faces: np.ndarray
    record: CollapseRecord
    opposite: np.ndarray
    asked: int
    advice: FaceAdvice

    @property
    def surface_map(self) -> SurfaceMap:
        """The bijection between base and input."""
        return SurfaceMap(self.record, self.faces, len(self.mesh.F))

    @property
    def message(self) -> str:
        """'', or one line on what could not be reached."""
        return base_message(len(self.F0), self.asked, self.advice)


def decimate(mesh: TriMesh, base_faces: int, variant: int = 0, progress: Progress = no_progress,
             room: bool = True) -> Decimation:
    """Collapse the edges of an oriented manifold mesh, in the unit frame, down to base_faces faces.

    The edge of least quadric error comes first (QEM, Garland and Heckbert 1997): E(x) = x'Ax + 2 b'x + c, summed over both ends,
    at the point x that makes it least; the map follows Liu et al. 2020 ("Neural Subdivision").
    base_faces AUTO: as many as the shape needs, FEWEST to MOST; from MOST on, the collapses end at the first that would
    cost more than DEAR, so a smooth shape gets few faces and a shape full of detail, handles or parts gets many.
    A number that can be reached is obeyed. Where the parts or handles of the mesh need more, the base gets as many as show
    them (see `face_bounds.face_advice`); without `room` handles get as few as they can do with.
    variant 0 takes the cheapest edge; k > 0 a random one among about 100 cheapest, seeded by k. A closed mesh has an
    even number of faces, so an odd target gives one face less; so does a target whose last single face is one that the border
    needs, or that would cost SINGLE times what any collapse before it did (half of a square that stands apart): a number of
    faces is a wish. A large mesh is decimated by its regions first, side by side (see `regions`). Deterministic, whatever the
    number of threads. Raises MeshError if the mesh is not an oriented manifold, and whatever `progress` raises.

    >>> import numpy as np
    >>> from npm_blender.core.decimation import decimate
    >>> from npm_blender.core.mesh import TriMesh
    >>> V = np.array([[x, y, 0.0] for y in (0, 1, 2) for x in (0, 1, 2)])
    >>> quads = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]]
    >>> base = decimate(TriMesh.from_arrays(V, [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])]), 2)
    >>> np.round(base.V0, 3).tolist()  # a flat square keeps its corners
    [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [2.0, 2.0, 0.0]]
    """
    progress = rising(progress)  # where parts or handles ask for a second run, too
    out = _collapse(mesh, base_faces, variant, progress)
    advice = face_advice(out.F0, base_faces, len(mesh.F) // 2 if room else 0)
    if advice.faces:
        out = _collapse(mesh, advice.faces, variant, progress)
    elif advice.cause == Cause.NONE:
        advice = out.advice
    return replace(out, asked=base_faces, advice=advice)


def _collapse(mesh: TriMesh, base_faces: int, variant: int, progress: Progress) -> Decimation:
    """All collapses, as `decimate` describes them, to a number of faces or AUTO."""
    progress(0.0, MESSAGE)
    enough, dear = (MOST, DEAR) if base_faces == AUTO else (0, np.inf)
    target = FEWEST if base_faces == AUTO else base_faces
    work = Decimator.of(mesh, TestColumns.of(ADMISSIBILITY_TESTS), enough or target, variant)
    opposite = work.mesh.opposite.copy()
    total, most, faces = work.faces, max(target, enough), np.inf

    def share(faces: float) -> float:
        return (total - faces) / max(total - target, 1)

    while worth_dividing(work.faces, most) and work.faces < STALLED * faces:
        faces = work.faces
        decimate_regions(work, most, dear, part(progress, share(faces), share(LEFT_SHARE * faces)), MESSAGE)
    work.offer_all()
    scratch, before = Scratch.make(), work.faces
    while work.faces > target:
        reason = work.run(scratch, Limits(target, SLICE, enough, dear))
        progress(share(work.faces), MESSAGE)
        if reason == DONE:
            break
        if reason == EMPTY:
            if work.faces == before and not _relent(work, target, enough):
                break
            before = work.faces
            work.offer_all()
    return _result(mesh, work, opposite, work.faces if enough else target)


def _relent(work: Decimator, target: int, enough: int) -> bool:
    """Where no collapse is left, allow those that would cut the border shorter; whether there were any such."""
    if work.counts[HAS_BORDER] and work.faces == target + 1:
        work.counts[HAS_BORDER] = 0  # rather a face less than a border that is cut short
        return True
    return work.faces > enough and work.corners.yield_to()


def _result(mesh: TriMesh, work: Decimator, opposite: np.ndarray, target: int) -> Decimation:
    """The base that is left of a mesh; target: the number of faces that it should have."""
    corner = work.mesh.corner.reshape(-1, 3)
    faces = np.flatnonzero(corner[:, 0] >= 0).astype(np.int32)
    vertices, F0 = np.unique(corner[faces], return_inverse=True)
    F0 = np.ascontiguousarray(F0.reshape(-1, 3), dtype=np.int32)
    closed = not (opposite == np.arange(len(opposite))).any()
    advice = FaceAdvice(cause=_cause(len(mesh.F), len(faces), target, closed))
    return Decimation(mesh, work.mesh.X[vertices], F0, vertices.astype(np.int32), faces, work.record.used(), opposite, target,
                      advice)


def _cause(before: int, found: int, target: int, closed: bool) -> Cause:
    """Why a mesh of so many faces has become one of `found`, and not of `target`."""
    if found == target:
        return Cause.NONE
    if before < target:
        return Cause.SMALL_INPUT
    if found < target and closed:
        return Cause.EVEN
    return Cause.NO_COLLAPSE if found > target else Cause.SINGLE_FACE
