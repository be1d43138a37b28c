"""Compress a mesh to an `.npmesh` stream and open one again: the summary of the whole core."""

from dataclasses import dataclass, field, replace
from importlib.util import find_spec

from ..bitstream import canonical_order
from ..cleaning import clean
from ..decimation import decimate, needs_compiling
from ..errors import DependencyError
from ..levels import LodSequence
from ..levels import build_levels as lod_levels
from ..mesh import Level, TriMesh, UnitFrame, hierarchy, in_morton_order
from ..network import load_weights
from ..progress import Progress, no_progress, noted
from ..settings import CompressSettings, ComputeSettings, LodSettings
from .progressive_mesh import ProgressiveMesh, open_stream
from .rate_control import level_count_for, within_budget
from .sender import Sender
from .stage_clock import StageClock

REFINE_STEPS = 24


@dataclass(frozen=True)
class CompressReport:
    """What happened. faces: of the source; bytes: of the stream; features: sent; cleaning: one line; messages: what the
    user should know; seconds: by stage (clean, decimate, levels, encode, refine, order, write)."""

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
    """A stream and the report of its making."""

    data: bytes
    report: CompressReport


def compress(
    mesh: TriMesh,
    settings: CompressSettings | None = None,
    progress: Progress = no_progress,
    compute: ComputeSettings | None = None,
) -> Compressed:
    """Compress a mesh in object space to an `.npmesh` stream. compute: what refinement may use of the machine.

    Raises MeshError (what does not qualify), SettingsError (a budget that does not pay for the base mesh), WeightsError,
    DependencyError (refinement asked for without torch), Cancelled (from `progress`).
    """
    if needs_compiling():
        progress = noted(progress, "first run: compiling takes up to a minute")
    settings = settings or CompressSettings()
    refine_steps = _refine_steps(settings)
    model = load_weights()
    clock = StageClock(
        progress,
        {
            "clean": 1,
            "decimate": 4,
            "levels": 1,
            "encode": 1,
            "refine": 24 if refine_steps else 0.01,
            "order": 0.5,
            "write": 0.5,
        },
    )
    cleaned, cleaning = clock.run("clean", clean, mesh, settings.lod.clean)
    frame = UnitFrame.of(cleaned.V)
    unit = in_morton_order(TriMesh(frame.to_unit(cleaned.V), cleaned.F))

    def sent(base_faces: int, room: bool) -> tuple[Sender, tuple[bytes, int]]:
        lod, levels = _sequence(unit, replace(settings.lod, base_faces=base_faces), room, clock)
        sender = Sender(model, unit, lod, levels, settings, refine_steps, compute or ComputeSettings(), clock)
        return sender, sender.send(frame, mesh)

    sender, (data, features) = within_budget(sent, settings)
    lod = sender.lod
    messages = tuple(message for message in (lod.message, sender.message) if message)
    return Compressed(
        data,
        CompressReport(
            len(mesh.F), len(lod.F0), lod.level_count, len(data), features, cleaning.summary, messages, clock.seconds
        ),
    )


def _sequence(unit: TriMesh, settings: LodSettings, room: bool, clock: StageClock) -> tuple[LodSequence, list[Level]]:
    """The LoD sequence of a mesh in the unit frame, its base numbered as the receiver numbers it, and its levels.

    room: as in `decimate`.
    """
    decimation = clock.run("decimate", lambda p: decimate(unit, settings.base_faces, settings.variant, p, room))
    count = settings.levels or level_count_for(len(decimation.F0))

    def build(report: Progress) -> LodSequence:
        order = canonical_order(decimation.F0, len(decimation.V0))
        return lod_levels(decimation, count, order, progress=report)

    lod = clock.run("levels", build)
    return lod, hierarchy(lod.F0, len(lod.V0), lod.level_count)


def _refine_steps(settings: CompressSettings) -> int:
    if settings.refine_steps is None:
        return REFINE_STEPS if find_spec("torch") else 0
    if settings.refine_steps and not find_spec("torch"):
        raise DependencyError("Expected torch for --refine-steps, found none; install torch or use 0 refine steps")
    return settings.refine_steps


__all__ = ["Compressed", "CompressReport", "ProgressiveMesh", "compress", "open_stream"]
