"""Compress a mesh to an `.npmesh` stream and open one again: the summary of the whole core."""

import warnings
from dataclasses import dataclass, field

from ..bitstream import order_connectivity
from ..cleaning import clean
from ..decimation import decimate, needs_compiling
from ..errors import MeshError, SettingsError
from ..levels import build_levels
from ..mesh import TriMesh, hierarchy
from ..network import load_weights
from ..progress import Progress, no_progress, noted
from ..settings import AUTO, PAPER, PAPER_FACES, PAPER_LEVELS, CompressSettings, LodSettings
from .displaced_sender import default_faces, ladder, one_rung
from .paper_sender import PaperSender, Sequence
from .size_search import best_for
from .source_facts import SourceFacts, in_frame, lattice_frame
from .stage_clock import StageClock
from .target import Target

COMPILING = "first run: compiling takes up to a minute"
SHARES = {"clean": 1, "fit": 8, "write": 0.2}  # of the progress bar
PAPER_SHARES = {"clean": 1, "decimate": 2, "levels": 1, "encode": 1, "order": 0.5, "write": 0.5}
BYTES_PER_FACE, LEAST_BYTES, MOST_BYTES = 2, 4_000, 40_000  # of a stream that is not made for a size, about: of the source


@dataclass(frozen=True)
class CompressReport:
    """What happened. faces: of the source; bytes: of the stream; features: sent; cleaning: one line; messages: what the
    user should know; seconds: by stage (clean, fit, write).

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
) -> Compressed:
    """Compress a mesh in object space to an `.npmesh` stream (the sender of the paper's section 3).

    progress: told how far it is; where there is none, a UserWarning says if code has to be compiled first. Raises MeshError (what
    does not qualify), SettingsError (a budget that does not pay for the base mesh), WeightsError, Cancelled (from `progress`).

    >>> from npm_blender.core import CompressSettings, LodSettings, TriMesh, compress, open_stream
    >>> V = [[x, y, x * y / 8] for y in range(5) for x in range(5)]
    >>> F = [f for i in range(19) if i % 5 < 4 for f in ([i, i + 1, i + 5], [i + 1, i + 6, i + 5])]
    >>> settings = CompressSettings(LodSettings(base_faces=8, levels=1))
    >>> made = compress(TriMesh.from_arrays(V, F), settings, progress=lambda fraction, message: None)
    >>> made.report.base_faces, len(open_stream(made.data).decode(level=1).F)
    (8, 32)
    """
    _check_arguments(mesh, settings)
    progress, settings = _told_of_compiling(progress), settings or CompressSettings()
    paper = settings.model == PAPER
    clock = StageClock(progress, PAPER_SHARES if paper else SHARES)
    with clock.stage("clean") as report:
        cleaned, cleaning = clean(mesh, settings.lod.clean, report)
    frame = lattice_frame(cleaned.V)
    unit = in_frame(cleaned, frame)
    found = (_paper if paper else _displaced)(unit, SourceFacts(frame, len(mesh.F), len(mesh.V)), settings, clock)
    messages = (found.message,) if found.message else ()
    made = CompressReport(len(mesh.F), found.base_faces, found.levels, len(found.data), found.features, cleaning.summary,
                             messages, clock.seconds)
    return Compressed(found.data, made)


@dataclass(frozen=True)
class _Sent:
    """A stream and what is said of it."""

    data: bytes
    features: int
    base_faces: int
    levels: int
    message: str


def _displaced(unit: TriMesh, facts: SourceFacts, settings: CompressSettings, clock: StageClock) -> _Sent:
    """The stream of a displaced surface."""
    with clock.stage("fit") as report:
        report(0.0, "Fitting")
        target = Target(unit, facts)
        if settings.budget:
            best = best_for(target, settings, report)
            return _Sent(best.data, best.features, len(best.base.surface.F0), best.base.surface.levels, "")
        lod = settings.lod
        most = min(max(BYTES_PER_FACE * len(unit.F), LEAST_BYTES), MOST_BYTES)
        if lod.base_faces == lod.levels == AUTO:
            made = ladder(target, settings.position_bits, most, report)
        else:  # numbers are obeyed
            faces = lod.base_faces or default_faces(len(unit.F))
            made = one_rung(target, faces, lod.levels, settings.position_bits, most, report)
    with clock.stage("write") as report:
        report(0.0, "Writing")
        data, count = made.stream()
    surfaces = [stages.base.surface for stages in made.rungs]
    return _Sent(data, count, len(surfaces[0].F0), max(surface.levels for surface in surfaces), made.message)


def _paper(unit: TriMesh, facts: SourceFacts, settings: CompressSettings, clock: StageClock) -> _Sent:
    """The paper's own stream."""
    lod = settings.lod
    with clock.stage("decimate") as report:
        decimation = decimate(unit, lod.base_faces or PAPER_FACES, lod.variant, report)
    with clock.stage("levels") as report:
        order, connectivity = order_connectivity(decimation.F0, len(decimation.V0))
        sequence = build_levels(decimation, lod.levels or PAPER_LEVELS, order, progress=report)
    levels = hierarchy(sequence.F0, len(sequence.V0), sequence.level_count)
    sender = PaperSender(load_weights(), Sequence(unit, sequence, levels, connectivity), settings.order, clock)
    data, count = sender.send(facts, settings.position_bits, settings.budget)
    return _Sent(data, count, len(sequence.F0), sequence.level_count, sequence.message)


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
