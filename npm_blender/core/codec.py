"""Compress a mesh to an `.npmesh` stream and open one again: the summary of the whole core."""

from dataclasses import dataclass, field
from importlib.util import find_spec

from . import collapses
from . import weights as weight_file
from .clean import clean
from .connectivity import canonical_order
from .decimate import decimate
from .errors import DependencyError
from .jit import is_cold
from .locality import in_morton_order
from .lod import LodSequence
from .lod import levels as lod_levels
from .mesh import Frame, TriMesh
from .progress import Progress, no_progress, noted
from .progressive import ProgressiveMesh, open_stream
from .sender import Clock, Sender
from .settings import CompressSettings, ComputeSettings
from .subdivide import hierarchy

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

    Raises MeshError (what does not qualify), WeightsError, DependencyError (refinement asked for without torch),
    Cancelled (from `progress`).
    """
    if is_cold(collapses.run):
        progress = noted(progress, "first run: compiling takes up to a minute")
    settings = settings or CompressSettings()
    refine_steps = _refine_steps(settings)
    model = weight_file.load()
    clock = Clock(
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
    frame = Frame.of(cleaned.V)
    unit = in_morton_order(TriMesh(frame.to_unit(cleaned.V), cleaned.F))
    decimation = clock.run("decimate", decimate, unit, settings.lod.base_faces, settings.lod.variant)

    def build(report: Progress) -> LodSequence:
        order = canonical_order(decimation.F0, len(decimation.V0))
        return lod_levels(decimation, settings.lod.levels, order, progress=report)

    lod = clock.run("levels", build)
    levels = hierarchy(lod.F0, len(lod.V0), lod.levels)
    sender = Sender(model, unit, lod, levels, settings, refine_steps, compute or ComputeSettings(), clock)
    data, features = sender.send(frame, mesh)
    messages = tuple(message for message in (lod.message, sender.message) if message)
    return Compressed(
        data,
        CompressReport(
            len(mesh.F), len(lod.F0), lod.levels, len(data), features, cleaning.summary, messages, clock.seconds
        ),
    )


def _refine_steps(settings: CompressSettings) -> int:
    if settings.refine_steps is None:
        return REFINE_STEPS if find_spec("torch") else 0
    if settings.refine_steps and not find_spec("torch"):
        raise DependencyError("Expected torch for --refine-steps, found none; install torch or use 0 refine steps")
    return settings.refine_steps


__all__ = ["Compressed", "CompressReport", "ProgressiveMesh", "compress", "open_stream"]
