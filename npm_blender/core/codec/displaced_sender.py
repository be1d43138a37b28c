"""The sender of a displaced surface for all sizes: a fitted base, then stages until they help no more."""
import numpy as np

from ..bitstream import encode_displacements
from ..progress import Progress, no_progress, part
from .fitted_base import LEAST_ERROR, SCHEMES, FittedBase, FreeBase
from .stages import Stages
from .target import Target

DEFAULT_FACES = 800             # of a base: about 0.8 kB
WHOLE = 1600                    # faces of a mesh that is its own base: a few kB
ENOUGH = 2                      # levels of a smooth scheme
STAGES = 14                     # at most
BETTER = 0.98                   # a stage that leaves more than this of the error, and the next one, end the stream


def default_faces(target: Target) -> int:
    """Faces of the base of a stream for all sizes: all of a mesh that has few."""
    faces = len(target.mesh.F)
    return faces if faces <= WHOLE else DEFAULT_FACES


def staged(target: Target, base: FittedBase, most: int, progress: Progress = no_progress) -> Stages:
    """Stages until they help no more, nobody sees more, or there are `most` bytes."""
    out = Stages(target, base)
    if not base.surface.levels:
        return out
    poor = 0
    for stage in range(STAGES):
        progress(stage / STAGES, "Fitting details")
        poor = poor + 1 if out.add() > BETTER else 0
        if poor == 2 or out.errors[-1] < LEAST_ERROR or _size(out) > most:
            break
    while out.values and out.errors[-1] == out.errors[-2]:
        del out.values[-1], out.errors[-1]
    return out


def checked(target: Target, faces: int, levels: int, bits: int, most: int,
            progress: Progress = no_progress) -> tuple[Stages, str]:
    """A base of about so many faces with stages, of which no finer level is farther off than a coarser one; and a message.

    The levels that are farther off are left out. Where a smooth scheme would leave few (large flat faces), new vertices are
    midpoints, which change nothing by themselves.
    """
    for schemes in (SCHEMES, SCHEMES[:1]):
        free = FreeBase(target, faces, levels, part(progress, 0, 0.3), schemes=schemes)
        stages = staged(target, free.rounded(bits), most, part(progress, 0.3, 1))
        finest = stages.settle()
        if finest >= min(stages.base.surface.levels, ENOUGH) or not stages.base.surface.smooth:
            break
    if finest < stages.base.surface.levels:
        stages.leave_out(finest)
    return stages, free.message


def _size(stages: Stages) -> int:
    """Bytes of the numbers of all stages."""
    return len(encode_displacements(np.array(stages.values), stages.near, stages.base.surface.first)[0])
