"""Compress a mesh to an `.npmesh` stream and open one again: the summary of the whole core."""

import warnings
from dataclasses import dataclass, field, replace

from ..bitstream import order_connectivity
from ..cleaning import clean
from ..decimation import decimate, needs_compiling
from ..errors import MeshError, SettingsError
from ..levels import build_levels
from ..mesh import TriMesh, UnitFrame, hierarchy, in_morton_order
from ..network import load_weights
from ..progress import Progress, no_progress, noted
from ..settings import AUTO, CompressSettings, ComputeSettings, LodSettings, has_torch
from .contents import SourceFacts
from .rate_control import level_count_for, within_budget
from .sender import Sender, Sequence
from .stage_clock import StageClock

COMPILING = "first run: compiling takes up to a minute"
SHARES = {"clean": 1, "decimate": 4, "levels": 1, "encode": 1, "refine": 24, "order": 0.5, "write": 0.5}  # of the progress bar


@dataclass(frozen=True)
class CompressReport:
    """What happened. faces: of the source; bytes: of the stream; features: sent; cleaning: one line; messages: what the
    user should know; seconds: by stage (clean, decimate, levels, encode, refine, order, write).

    >>> from npm_blender.core.codec import CompressReport
    >>> report = CompressReport(1280, 80, 2, 900, 120, "nothing to repair", (), {"clean": 0.25, "write": 0.5})
    >>> sum(report.seconds.values())
    0.75
    """

    faces: int
    base_faces: int
    levels: int
    bytes: int
    features: int
    cleaning: str
    messages: tuple[str, ...]
    seconds: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Compressed:
    """A stream and the report of its making.

    >>> from npm_blender.core.codec import Compressed, CompressReport
    >>> made = Compressed(b"npm", CompressReport(1280, 80, 2, 3, 120, "nothing to repair", ()))
    >>> len(made.data) == made.report.bytes
    True
    """

    data: bytes
    report: CompressReport


def compress(
    mesh: TriMesh,
    settings: CompressSettings | None = None,
    progress: Progress | None = None,
    compute: ComputeSettings | None = None,
) -> Compressed:
    """Compress a mesh in object space to an `.npmesh` stream (the sender of the paper's section 3).

    progress: told how far it is; where there is none, a UserWarning says if code has to be compiled first; compute: what
    refinement may use of the machine. Raises MeshError (what does not qualify), SettingsError (a budget that does not pay for
    the base mesh), WeightsError, DependencyError (refinement asked for without torch), Cancelled (from `progress`).

    >>> from npm_blender.core import CompressSettings, LodSettings, TriMesh, compress, open_stream
    >>> V = [[x, y, x * y / 8] for y in range(5) for x in range(5)]
    >>> F = [f for i in range(19) if i % 5 < 4 for f in ([i, i + 1, i + 5], [i + 1, i + 6, i + 5])]
    >>> settings = CompressSettings(LodSettings(base_faces=8, levels=1), refine_steps=0)
    >>> made = compress(TriMesh.from_arrays(V, F), settings, progress=lambda fraction, message: None)
    >>> made.report.base_faces, len(open_stream(made.data).decode(level=1).F)
    (8, 32)
    """
    _check_arguments(mesh, settings)
    progress = _told_of_compiling(progress)
    settings = (settings or CompressSettings()).resolved(has_torch())
    model = load_weights()
    clock = StageClock(progress, SHARES if settings.refine_steps else {**SHARES, "refine": 0.01})
    with clock.stage("clean") as report:
        cleaned, cleaning = clean(mesh, settings.lod.clean, report)
    frame = UnitFrame.of(cleaned.V)
    unit = in_morton_order(TriMesh(frame.to_unit(cleaned.V), cleaned.F))
    source = SourceFacts(frame, len(mesh.F), len(mesh.V))

    def sent(base_faces: int, room: bool) -> tuple[Sender, tuple[bytes, int]]:
        sequence = _sequence(unit, replace(settings.lod, base_faces=base_faces), room, clock)
        sender = Sender(model, sequence, settings, compute or ComputeSettings(), clock)
        return sender, sender.send(source)

    sender, (data, features) = within_budget(sent, settings)
    lod = sender.lod
    messages = tuple(message for message in (lod.message, sender.message) if message)
    return Compressed(
        data,
        CompressReport(
            len(mesh.F), len(lod.F0), lod.level_count, len(data), features, cleaning.summary, messages, clock.seconds
        ),
    )


def _check_arguments(mesh: TriMesh, settings: CompressSettings | None) -> None:
    """Raise MeshError or SettingsError for arguments of another kind."""
    if not isinstance(mesh, TriMesh):
        found = "an array" if hasattr(mesh, "__array__") else f"a {type(mesh).__name__}"
        raise MeshError(f"Expected a TriMesh, found {found}; call compress(TriMesh.from_arrays(V, F))")
    if settings is not None and not isinstance(settings, CompressSettings):
        found, call = f"a {type(settings).__name__}", "CompressSettings(...)"
        if isinstance(settings, LodSettings):
            call = "CompressSettings(lod=LodSettings(...))"
        raise SettingsError(f"Expected CompressSettings, found {found}; call compress(mesh, {call})")


def _told_of_compiling(progress: Progress | None) -> Progress:
    """`progress`, with a note where this run has to compile code first; where there is none, a warning says so."""
    if progress is None or progress is no_progress:
        if needs_compiling():
            warnings.warn(f"compress: {COMPILING}", UserWarning, stacklevel=3)
        return no_progress
    return noted(progress, COMPILING) if needs_compiling() else progress


def _sequence(unit: TriMesh, settings: LodSettings, room: bool, clock: StageClock) -> Sequence:
    """The LoD sequence of a mesh in the unit frame, its base numbered as the receiver numbers it, and its levels.

    room: as in `decimate`.
    """
    with clock.stage("decimate") as report:
        decimation = decimate(unit, settings.base_faces, settings.variant, report, room)
    count = level_count_for(len(decimation.F0)) if settings.levels == AUTO else settings.levels
    with clock.stage("levels") as report:
        order, connectivity = order_connectivity(decimation.F0, len(decimation.V0))
        lod = build_levels(decimation, count, order, progress=report)
    return Sequence(unit, lod, hierarchy(lod.F0, len(lod.V0), lod.level_count), connectivity)
