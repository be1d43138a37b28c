"""The sender of a stream for all sizes: a ladder of rungs, of which each has a finer base than the one before.

A rung is a fitted base, then stages until they help no more. Another one pays where its base alone is nearer than the stages of
the rung before are at as many bytes (flat and mechanical parts above all); the last one may be the mesh itself. Where a rung
ends is chosen by measured errors, for the sizes between LEAST_BYTES and MOST_BYTES.
"""
from dataclasses import dataclass

import numpy as np

from ..bitstream import BASE_NUMBERS, write_ladder
from ..progress import Progress, no_progress, part
from ..settings import AUTO
from .fitted_base import LEAST_ERROR, PLAIN, SCHEMES, FreeBase
from .stages import Stages
from .target import Target

DEFAULT_FACES = 800             # of the first base: about 1 kB
COARSER = 6                     # times fewer than the source has, at least
FINER, FEWEST = 4, 2.5          # times as many faces in the next base, where the source has so many times more than that
LEAD = 1.5                      # bytes of the first rung for each face of the next base, before that is tried
WHOLE = 1600                    # faces of a mesh that is its own base: a few kB
ENOUGH = 2                      # levels of a smooth scheme
STAGES = 14                     # at most
PATIENT = 3                     # stages that may be of no use at first: their steps are large
BETTER = 0.98                   # a stage that leaves more than this of the error, and the next one, end the rung
LEAST_BYTES, MOST_BYTES = 500, 40_000  # between which errors count
LEAST_FALL, MOST_FALL = 0.2, 1.5  # of errors with bytes, where they are not measured: error ~ bytes ** -fall
GAIN = 0.12                     # of the mean of log errors, that a rung has to bring
VISIBLE = 2e-5                  # nobody sees less, unit frame
EXACT_BITS = 14                 # of a coordinate of the mesh itself: steps of 3 VISIBLE
SAME = 1.01                     # errors that differ by less are the same: samples


@dataclass(frozen=True)
class Ladder:
    """What is sent: rungs, the last one the finest; message: what the user should know of the base."""

    rungs: list[Stages]
    message: str

    def stream(self) -> tuple[bytes, int]:
        """The stream, and how many features it has."""
        coded = [stages.rung(stages.table, stages.step) for stages in self.rungs]
        bases = sum(BASE_NUMBERS * len(stages.base.grid) for stages in self.rungs[1:])
        return write_ladder(coded), bases + sum(rung.header.total_features for rung in coded)


def default_faces(faces: int) -> int:
    """Faces of the first base of a stream for all sizes, for a source of so many: all of a mesh that has few."""
    return faces if faces <= WHOLE else min(DEFAULT_FACES, faces // COARSER)


def ladder(target: Target, bits: int, most: int, progress: Progress = no_progress) -> Ladder:
    """Rungs for all sizes up to about `most` bytes; bits: of the coordinates of bases, or AUTO."""
    whole = len(target.mesh.F)
    faces = default_faces(whole)
    exact = _exact(target, bits) if faces < whole else None
    limit = exact.base_size if exact else most  # beyond it the mesh itself is nearer
    finer = FINER * faces
    another = whole >= FEWEST * finer
    found = one_rung(target, faces, AUTO, bits, int(LEAD * finer) if another else limit,
                     part(progress, 0, 0.4 if another else 1))
    rungs, first = found.rungs, found.rungs[0]
    if another:
        free = FreeBase(target, finer, AUTO, part(progress, 0.4, 0.6), schemes=(first.base.scheme,))
        second = Stages(target, free.rounded(bits))
        if _placed(first, second):
            more_stages(second, limit, part(progress, 0.6, 1))
            if _settled(second) and _follows(first, second):
                rungs.append(second)
        if len(rungs) == 1:
            more_stages(first, limit, part(progress, 0.6, 1))
    if exact and _placed(rungs[-1], exact):
        if _follows(rungs[-1], exact):
            rungs.append(exact)
        else:  # what was cut for it comes back
            more_stages(rungs[-1], limit)
    for rung in rungs:
        _settled(rung)
    return Ladder(rungs, found.message)


def _exact(target: Target, bits: int) -> Stages | None:
    """The mesh itself as the last rung; None where it takes more than MOST_BYTES."""
    faces = len(target.mesh.F)
    if faces > MOST_BYTES:  # it takes about a byte for a face
        return None
    found = Stages(target, FreeBase(target, faces, PLAIN).rounded(bits or EXACT_BITS))
    return found if found.base_size <= MOST_BYTES else None


def _placed(below: Stages, above: Stages) -> bool:
    """Cut the stages of a rung where the next one begins best; whether it does at all.

    Best: the mean of the logarithms of errors over those of sizes is least. Beyond what is known errors fall with the bytes as
    those of the last stage did; those of the next rung as fast as those from base to base, in the mean of both.
    """
    sizes, errors = below.sizes(), np.maximum(below.errors, VISIBLE)
    base, start = above.base_size, max(above.base.error, VISIBLE)
    slope = _fall(sizes[-2:], errors[-2:]) if len(sizes) > 1 else LEAST_FALL
    finer = (slope + _fall(np.array([sizes[0], base]), np.array([errors[0], start]))) / 2
    at = np.geomspace(LEAST_BYTES, MOST_BYTES, 64)
    shown = np.maximum(np.searchsorted(sizes, at, side="right") - 1, 0)

    def mean(error: np.ndarray) -> float:
        return float(np.log(np.maximum(error, VISIBLE)).mean())

    alone = mean(np.where(at < sizes[-1], errors[shown], errors[-1] * (sizes[-1] / at) ** slope))
    with_next = [mean(np.where(at < size + base, errors[np.minimum(shown, k)],
                               start * (base / np.maximum(at - size, 1)) ** finer)) for k, size in enumerate(sizes)]
    place = int(np.argmin(with_next))
    if with_next[place] > alone - GAIN:
        return False
    below.keep(place)
    return True


def _fall(sizes: np.ndarray, errors: np.ndarray) -> float:
    """The exponent with which errors (2,) fall with sizes (2,)."""
    return float(np.clip(np.log(errors[0] / errors[1]) / np.log(sizes[1] / sizes[0]), LEAST_FALL, MOST_FALL))


def _settled(stages: Stages) -> bool:
    """Leave out levels that are farther off than coarser ones; whether any are left."""
    finest = stages.settle()
    while finest < stages.base.surface.levels:
        stages.leave_out(finest)
        finest = stages.settle()
    return finest > 0 or not stages.base.surface.levels


def _follows(below: Stages, above: Stages) -> bool:
    """Whether no level gets farther off where the next rung begins."""
    below.settle()
    above.settle()
    before, after = below.level_errors[-1], above.level_errors[0]
    return all(after[min(level, len(after) - 1)] <= SAME * before[min(level, len(before) - 1)]
               for level in range(max(len(before), len(after))))


def more_stages(stages: Stages, most: int, progress: Progress = no_progress) -> None:
    """Stages until they help no more, nobody sees more, or there are `most` bytes."""
    if not stages.base.surface.levels:
        return
    poor = 0
    for stage in range(len(stages.values), STAGES):
        progress(stage / STAGES, "Fitting details")
        poor = poor + 1 if stages.add() > BETTER else 0
        if (poor == 2 and stage >= PATIENT) or stages.errors[-1] < LEAST_ERROR or stages.sizes()[-1] > most:
            break
    while stages.values and stages.errors[-1] == stages.errors[-2]:
        stages.keep(len(stages.values) - 1)


def one_rung(target: Target, faces: int, levels: int, bits: int, most: int, progress: Progress = no_progress) -> Ladder:
    """A base of about so many faces with stages, of which no finer level is farther off than a coarser one.

    The levels that are farther off are left out. Where a smooth scheme would leave few (large flat faces), new vertices are
    midpoints, which change nothing by themselves.
    """
    for schemes in (SCHEMES, SCHEMES[:1]):
        free = FreeBase(target, faces, levels, part(progress, 0, 0.3), schemes=schemes)
        stages = Stages(target, free.rounded(bits))
        more_stages(stages, most, part(progress, 0.3, 1))
        finest = stages.settle()
        if finest >= min(stages.base.surface.levels, ENOUGH) or not stages.base.surface.smooth:
            break
    _settled(stages)
    return Ladder([stages], free.message)
