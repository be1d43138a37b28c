"""Compress a mesh to an `.npmesh` stream and open one again: the summary of the whole core."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.util import find_spec

import numpy as np

from . import collapses
from . import features as ordering
from . import weights as weight_file
from .backend import NUMPY
from .basecoder import quantize_positions
from .clean import clean
from .connectivity import canonical_order
from .decimate import decimate
from .decoder import FEATURES, decode
from .encoder import encode
from .errors import DependencyError
from .jit import is_cold
from .locality import in_morton_order
from .lod import LodSequence
from .lod import levels as lod_levels
from .mesh import Frame, TriMesh
from .operators import MeshIndex
from .progress import Progress, no_progress, noted, part
from .progressive import ProgressiveMesh, open_stream
from .settings import CompressSettings, ComputeSettings
from .stream import Header, write_stream
from .subdivide import Level, hierarchy
from .surface import Surface

REFINE_STEPS = 24
FEATURE_STEP = 0.5  # quantization step on the finest trained level; refinement knows of the rounding
KEPT = ordering.STAGES[1]  # features of the order that are sent even if they are zero
FEATURE_ERROR = 8e-4  # a mesh that is off by less without features gets finer steps, down to a tenth


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


class _Clock:
    """Seconds by stage; the stages' shares of the progress bar."""

    def __init__(self, progress: Progress, shares: dict[str, float]) -> None:
        self.seconds: dict[str, float] = {}
        total, start, self._parts = sum(shares.values()), 0.0, {}
        for name, share in shares.items():
            self._parts[name] = part(progress, start / total, (start + share) / total)
            start += share

    def run(self, name: str, step: Callable, *arguments):
        """step(*arguments, progress), timed under `name`."""
        begun = time.perf_counter()
        try:
            return step(*arguments, self._parts[name])
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - begun


def step_scale(error: float) -> float:
    """Scale of everything that touches features, 0.1 to 1, from a mesh's error without features (unit frame)."""
    return float(np.clip(error / FEATURE_ERROR, 0.1, 1))


def feature_steps(levels: int, scale: float = 1.0) -> np.ndarray:
    """Quantization step of the features of each level, (levels,) float32: finer where a feature moves more surface."""
    return np.array([scale * FEATURE_STEP * max(0.5, 0.7 ** max(2 - i, 0)) for i in range(levels)], dtype=np.float32)


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
    clock = _Clock(
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
    sender = _Sender(model.params, unit, lod, levels, settings, refine_steps, compute or ComputeSettings())
    data, features = sender.send(clock, model, frame, mesh)
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


class _Sender:
    """The steps of the sender from the LoD sequence to bytes."""

    def __init__(
        self,
        params: dict,
        unit: TriMesh,
        lod: LodSequence,
        levels: list[Level],
        settings: CompressSettings,
        refine_steps: int,
        compute: ComputeSettings,
    ) -> None:
        self.params, self.unit, self.lod, self.levels, self.settings = params, unit, lod, levels, settings
        self.refine_steps, self.compute = refine_steps, compute
        self.message = ""
        self.meshes = [MeshIndex.of(NUMPY, level) for level in levels]
        self.surface = Surface(unit)
        areas = TriMesh(lod.V, levels[-1].F).face_areas()
        self.area = areas / areas.sum()

    def send(self, clock: _Clock, model, frame: Frame, source: TriMesh) -> tuple[bytes, int]:
        """All steps: (stream, number of features)."""
        refiner = clock.run("refine", self._refiner) if self.refine_steps else None
        V0 = clock.run("refine", lambda p: refiner.base(self.lod.V0)) if refiner else self.lod.V0
        grid, V0 = quantize_positions(V0, self.settings.position_bits)
        values = clock.run("encode", self._encode, V0)
        scale = step_scale(self._error(V0))
        self.steps = feature_steps(self.lod.levels, scale)
        if refiner:
            values = clock.run("refine", lambda p: refiner.level_by_level(V0, values, scale))
        order = clock.run("order", self._order, V0, values)
        if refiner:
            ints = clock.run("refine", lambda p: refiner.staged(V0, values, order, self.steps, scale))
        else:
            ints = [np.rint(v / s).astype(np.int32) for v, s in zip(values, self.steps, strict=True)]

        def write(report: Progress) -> tuple[bytes, int]:
            report(0.0, "Writing")
            flat = np.concatenate(ints)
            # the first features are sent even where they were rounded to nothing, so that a stage ends where it was fitted
            sent = order[(flat[order] != 0).any(1) | (np.arange(len(order)) < KEPT)]
            level, face = ordering.split(sent, self.levels[:-1])
            header = Header(
                model_id=model.model_id,
                weights_hash=model.digest,
                levels=self.lod.levels,
                position_bits=self.settings.position_bits,
                feature_steps=tuple(map(float, self.steps)),
                total_features=len(sent),
                source_faces=len(source.F),
                source_vertices=len(source.V),
                centre=tuple(map(float, frame.centre)),
                size=frame.size,
            )
            return write_stream(header, grid, self.lod.F0, level, face, flat[sent]), len(sent)

        return clock.run("write", write)

    def _refiner(self, progress: Progress):
        from .refine import Refiner, Target

        target = Target(self.unit, self.surface, self.lod, self.levels)
        refiner = Refiner(self.params, target, self.refine_steps, progress, self.compute)
        if self.compute.device == "gpu" and refiner.device == "cpu":
            self.message = "refined on the processor, as torch finds no GPU"
        return refiner

    def _encode(self, V0: np.ndarray, progress: Progress) -> list[np.ndarray]:
        progress(0.0, "Encoding")
        Vs = [V0, *(self.lod.V[: level.n] for level in self.levels[1:])]
        return encode(NUMPY, self.params, [NUMPY.array(V) for V in Vs], self.meshes)

    def _error(self, V0: np.ndarray) -> float:
        """Mean distance of the decode without features to the input, unit frame."""
        none = [np.zeros((mesh.m, FEATURES), np.float32) for mesh in self.meshes[:-1]]
        V = decode(NUMPY, self.params, NUMPY.array(V0), none, self.meshes[:-1])[-1]
        distance, _, _ = self.surface.closest(V.astype(np.float64))
        return float(distance[self.levels[-1].F].mean(1) @ self.area)

    def _order(self, V0: np.ndarray, values: list[np.ndarray], progress: Progress) -> np.ndarray:
        progress(0.0, "Ordering features")
        flat = np.concatenate(values)
        if self.settings.order == "magnitude":
            return ordering.magnitude_order(flat)
        errors = []
        for count in range(self.lod.levels + 1):
            sent = [v if i < count else 0 * v for i, v in enumerate(values)]
            V = decode(NUMPY, self.params, NUMPY.array(V0), sent, self.meshes[:-1])[-1]
            error = np.abs(((V - self.lod.V) * self.lod.N).sum(1))
            errors.append(error[self.levels[-1].F].mean(1) * self.area)
        return ordering.staged_order(flat, errors, self.levels[:-1])


__all__ = ["Compressed", "CompressReport", "ProgressiveMesh", "compress", "feature_steps", "open_stream"]
