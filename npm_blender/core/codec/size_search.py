"""A stream that is made for a size: base, levels, bits and steps that leave the least error in so many bytes.

Candidates are displaced surfaces over bases of a few sizes, and plain bases without levels, which show flat and sharp things
best. All are made, measured the worse way, and compared.
"""
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from ..bitstream import encode_base, order_connectivity
from ..decimation import decimate
from ..progress import Progress, part
from ..settings import AUTO, CompressSettings
from .base_too_large import BaseTooLarge
from .fitted_base import PLAIN, FreeBase, levels_for
from .one_stage import OneStage
from .stages import Made, Stages
from .target import Target

HEAD = 50                       # bytes of a stream that are neither base nor details
FULL, AIM, TRIES = 0.975, 0.99, 3  # of the budget: what is full, what is aimed at, how often
PLAIN_BITS = (8, 9, 10, 11, 12, 13, 14)
BYTES_PER_FACE = 1.15           # of a base, about
FEWEST, FEW = 12, 1500          # faces of a base at least, and of one that gets three levels
SHARES = (0.75, 0.45)           # of the budget that the bases of displaced surfaces take


def best_for(target: Target, settings: CompressSettings, tell: Progress) -> Made:
    """The stream for the budget of the settings. Raises BaseTooLarge where no base is so small."""
    made = []
    candidates = list(_candidates(target, settings))
    for i, candidate in enumerate(candidates):
        found = candidate(part(tell, i / len(candidates), (i + 1) / len(candidates)))
        if found:
            made.append(found)
    if not made:
        free = FreeBase(target, settings.lod.base_faces or FEWEST, PLAIN, room=False)
        small = _whole(target, free, settings.position_bits or PLAIN_BITS[0])
        raise BaseTooLarge(len(small.data), len(small.base.surface.F0), settings.budget)
    return min(made, key=lambda one: one.error)


def _candidates(target: Target, settings: CompressSettings) -> Iterator[Callable[[Progress], Made | None]]:
    """What is tried."""
    budget, lod = settings.budget, settings.lod
    if lod.levels == AUTO:
        yield partial(_plain, target, settings)
    most = len(target.mesh.F)
    shares = [max(int(share * (budget - HEAD) / BYTES_PER_FACE), FEWEST) for share in SHARES]
    faces = [lod.base_faces] if lod.base_faces != AUTO else shares
    for count in sorted({min(count, most) for count in faces}, reverse=True):
        if count < most or lod.levels != AUTO:  # the whole mesh has nothing to gain from levels but that they are asked for
            yield partial(_displaced, target, settings, count)


def _plain(target: Target, settings: CompressSettings, tell: Progress) -> Made | None:
    """A base without levels that fills the budget, with the bits that suit it."""
    budget, asked, most = settings.budget, settings.lod.base_faces, len(target.mesh.F)
    tries = [settings.position_bits] if settings.position_bits else PLAIN_BITS
    faces = asked or min(max(int((budget - HEAD) / BYTES_PER_FACE), FEWEST), most)
    best: Made | None = None
    for attempt in range(TRIES):
        free = FreeBase(target, faces, PLAIN, part(tell, attempt / TRIES, (attempt + 0.5) / TRIES), room=bool(asked))
        options = []
        for bits in tries:
            tell((attempt + 0.5) / TRIES, "Trying bits")
            made = _whole(target, free, bits)
            size = len(made.data)
            if size <= budget and (best is None or made.error < best.error):
                best = made
            # the error that as many faces as fill the budget would leave
            options.append((made.error * (1 if asked else size / budget), size, bits))
        _, size, bits = min(options)
        if asked or (size <= budget and (size > FULL * budget or faces == most)):
            break
        faces = _faces_that_fill(target, budget, bits, faces, size)
        if faces < most and not settings.position_bits:  # of the whole mesh, all bits are tried again
            tries = [bits]
    return best


def _faces_that_fill(target: Target, budget: int, bits: int, faces: int, size: int) -> int:
    """Faces whose base takes about AIM of the budget, where so many took `size`; by bases that are not fitted."""
    scale = size / _unfitted_size(target, faces, bits)  # what the fit changes
    now: float = size
    for _ in range(TRIES):
        if 0.98 * budget < now < 0.998 * budget or (now < budget and faces == len(target.mesh.F)):
            break
        faces = min(max(int(faces * AIM * budget / now), FEWEST), len(target.mesh.F))
        now = scale * _unfitted_size(target, faces, bits)
    return faces


def _unfitted_size(target: Target, faces: int, bits: int) -> int:
    """Bytes of a stream of a base as decimation leaves it."""
    decimation = decimate(target.mesh, faces, room=False)
    order, connectivity = order_connectivity(decimation.F0, len(decimation.V0))
    grid = np.rint(decimation.V0[order.vertices] * 2.0**bits).astype(np.int64)
    return HEAD + len(connectivity) + len(encode_base(grid, order.F, connectivity).positions)


def _whole(target: Target, free: FreeBase, bits: int) -> Made:
    """A base without levels as a stream."""
    base = free.rounded(bits)
    stages = Stages(target, base)
    return Made(*stages.stream(stages.nothing(), 0), base.error, base)


def _displaced(target: Target, settings: CompressSettings, faces: int, tell: Progress) -> Made | None:
    """A displaced surface whose steps fill the budget. Handles get the faces that show them where the budget pays for those."""
    budget, lod = settings.budget, settings.lod
    levels = lod.levels or levels_for(faces, len(target.mesh.F), 3 if faces < FEW else 2)
    for room in (True, False) if lod.base_faces != AUTO else (False,):
        base = FreeBase(target, faces, levels, part(tell, 0, 0.4), room=room).rounded(settings.position_bits)
        stages = Stages(target, base)
        if len(stages.stream(stages.nothing(), 0)[0]) <= budget:
            return OneStage(stages).filled(budget, part(tell, 0.4, 1))
    return None
