"""The sender: from a LoD sequence to the bytes of a stream.

The base and the latents first, then the offsets in passes, each finer than the one before. With torch all of them are
fitted through the decoder; without it the latents are the encoder's and the offsets are traced to the surface.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..bitstream import quantize_positions
from ..geometry import ClosestPoints
from ..levels import LodSequence
from ..mesh import Level, TriMesh, UnitFrame
from ..network import FEATURES, NUMPY, MeshIndex, Weights, decode, encode
from ..progress import Progress
from ..refinement import traced_offsets
from ..settings import CompressSettings, ComputeSettings
from .contents import Contents, Offsets
from .importance import (
    LATENTS,
    carriers,
    edge_ranks,
    first_numbers,
    gain_order,
    magnitude_order,
    measured_gains,
    offset_order,
)
from .quantization import BASE_STEP, GROWTH, LEAST_BITS, LEAST_STEP, latent_steps, step_scale
from .rate_control import BaseTooLarge
from .stage_clock import StageClock


@dataclass(frozen=True)
class OffsetPass:
    """A pass over the offsets. step: quantization step on level 0, over the mean error of the mesh without offsets; bit:
    share of the loss for a bit, see `offsetfit`; embedded: whether it starts from traced offsets and its prefixes are
    fitted too; a pass that finds little left to do starts from zeros, which leaves most edges out."""

    step: float
    bit: float
    embedded: bool


OFFSET_PASSES = (OffsetPass(0.5, 5e-5, True), OffsetPass(0.125, 1e-5, False))
STAGES = 4 + sum(1 + plan.embedded for plan in OFFSET_PASSES)  # fits through the decoder: base, latents twice, offsets


class Sender:
    """What a mesh is sent as. All positions are in the unit frame."""

    def __init__(
        self,
        weights: Weights,
        unit: TriMesh,
        lod: LodSequence,
        levels: list[Level],
        settings: CompressSettings,
        refine_steps: int,
        compute: ComputeSettings,
        clock: StageClock,
    ) -> None:
        """unit: the cleaned input in the unit frame; levels: 0..L of `lod`; refine_steps: 0 to do without torch."""
        self.weights, self.params, self.unit, self.lod = weights, weights.params, unit, lod
        self.levels, self.feature_levels, self.settings = levels, levels[:-1], settings
        self.refine_steps, self.compute, self.clock = refine_steps, compute, clock
        self.message = ""
        self.meshes = [MeshIndex.of(NUMPY, level) for level in levels]
        self.surface = ClosestPoints(unit)
        areas = TriMesh(lod.V, levels[-1].F).face_areas()
        self.area = areas / areas.sum()

    def send(self, frame: UnitFrame, source: TriMesh) -> tuple[bytes, int]:
        """All steps: (stream, number of features). frame: of the cleaned input; source: for the counts in the header.

        Raises BaseTooLarge where the budget of the settings does not pay for the base mesh.
        """
        run, budget = self.clock.run, self.settings.budget
        refiner = run("refine", self._refiner) if self.refine_steps else None
        V0 = self.lod.V0
        if refiner:
            V0 = run("refine", lambda p: refiner.base(V0))
        bits = self._position_bits(V0)
        if refiner:
            V0 = run("refine", lambda p: refiner.base(V0, bits))
        grid, V0 = quantize_positions(V0, bits)
        none = self._no_latents(np.int32), np.zeros(0, np.int64)
        about = self.weights, self.feature_levels, frame, (len(source.F), len(source.V)), grid, bits, self.lod.F0
        contents = Contents(*about, latent_steps(self.lod.level_count), *none)
        if budget and len(contents.stream()) > budget:
            raise BaseTooLarge(len(contents.stream()), len(self.lod.F0), budget)
        contents = Contents(*about, *self._latents(refiner, V0))
        values = [i * s for i, s in zip(contents.latents, contents.steps, strict=True)]
        error = float(self._face_errors(V0, values, None).sum())
        sent = [np.zeros(len(mesh.edge_a)) for mesh in self.meshes[:-1]]
        for plan in OFFSET_PASSES:
            found = self._offsets(refiner, V0, values, sent, error, plan)
            contents = replace(contents, passes=(*contents.passes, found))
            sent = [a + b * s for a, b, s in zip(sent, found.ints, found.steps, strict=True)]
            if budget and len(contents.stream()) >= budget:
                break

        def write(report: Progress) -> tuple[bytes, int]:
            report(0.0, "Writing")
            return contents.within(budget)

        return run("write", write)

    def _no_latents(self, kind) -> list[np.ndarray]:
        return [np.zeros((len(level.F), FEATURES), kind) for level in self.feature_levels]

    def _position_bits(self, V0: np.ndarray) -> int:
        """Bits of a coordinate that resolve what the mesh is off by anyway, at most those of the settings."""
        error = max(float(self._face_errors(V0, self._no_latents(np.float32), None).sum()), 1e-9)
        return int(np.clip(np.ceil(-np.log2(BASE_STEP * error)), LEAST_BITS, self.settings.position_bits))

    def _refiner(self, progress: Progress):
        from ..refinement import Refiner, Target

        target = Target(self.unit, self.surface, self.lod, self.levels)
        refiner = Refiner(self.params, target, self.refine_steps, progress, self.compute)
        refiner.total = STAGES
        if self.compute.device == "gpu" and refiner.device == "cpu":
            self.message = "refined on the processor, as torch finds no GPU"
        return refiner

    def _latents(self, refiner, V0: np.ndarray) -> tuple[np.ndarray, list[np.ndarray], np.ndarray]:
        """Steps (L,), integers (m_i, 8) per level, and the numbers of those that are sent, in order of importance."""
        run = self.clock.run
        values = run("encode", self._encode, V0)
        scale = step_scale(float(self._face_errors(V0, [0 * v for v in values], None).sum()))
        steps = latent_steps(self.lod.level_count, scale)
        if refiner:
            values = run("refine", lambda p: refiner.level_by_level(V0, values, scale))
        order = run("order", self._latent_order, V0, values)
        if refiner:
            ints = run("refine", lambda p: refiner.latents(V0, values, order, steps, scale))
        else:
            ints = [np.rint(v / s).astype(np.int32) for v, s in zip(values, steps, strict=True)]
        flat, sent = np.concatenate(ints), np.zeros(sum(map(len, ints)), bool)
        sent[order] = True
        parts = np.split(flat * sent[:, None], first_numbers(self.feature_levels)[1:-1])
        return steps, parts, order[flat[order].any(1)]

    def _encode(self, V0: np.ndarray, progress: Progress) -> list[np.ndarray]:
        """The encoder's latents (m_i, 8) per level, zeros on levels above the first that have enough faces."""
        progress(0.0, "Encoding")
        Vs = [V0, *(self.lod.V[: level.n] for level in self.levels[1:])]
        values = encode(NUMPY, self.params, [NUMPY.array(V) for V in Vs], self.meshes)
        enough = np.cumsum([len(v) for v in values]) >= LATENTS
        return [v * (i == 0 or not enough[i - 1]) for i, v in enumerate(values)]

    def _latent_order(self, V0: np.ndarray, values: list[np.ndarray], progress: Progress) -> np.ndarray:
        progress(0.0, "Ordering features")
        flat = np.concatenate(values)
        if self.settings.order == "magnitude":
            return magnitude_order(flat)[:LATENTS]
        errors = []
        for count in range(self.lod.level_count + 1):
            sent = [v if i < count else 0 * v for i, v in enumerate(values)]
            V = decode(NUMPY, self.params, NUMPY.array(V0), sent, self.meshes[:-1])[-1]
            error = np.abs(((V - self.lod.V) * self.lod.N).sum(1))
            errors.append(error[self.levels[-1].F].mean(1) * self.area)
        return gain_order(flat, measured_gains(errors, self.feature_levels))[:LATENTS]

    def _offsets(self, refiner, V0: np.ndarray, latents: list, before: list, error: float, plan: OffsetPass) -> Offsets:
        """One pass on top of the offsets `before`, for a mesh that is off by `error` without any."""
        run, levels = self.clock.run, self.feature_levels
        steps = (max(plan.step * error, LEAST_STEP) * GROWTH ** np.arange(len(levels))).astype(np.float32)
        if plan.embedded or not refiner:
            ints = run("encode", self._traced, V0, latents, before, steps)
        else:
            ints = [0 * b for b in before]
        if refiner:
            from ..refinement import OffsetFit

            fit = OffsetFit(refiner, V0, latents, before, steps, plan.bit)
            start = ints
            ints = run("refine", lambda p: fit.whole(start))

        def ranked(progress: Progress) -> np.ndarray:
            progress(0.0, "Ordering features")
            errors = []
            for count in range(self.lod.level_count + 1):
                added = [o * s * (i < count) for i, (o, s) in enumerate(zip(ints, steps, strict=True))]
                errors.append(self._face_errors(V0, latents, [b + a for b, a in zip(before, added, strict=True)]))
            return offset_order(ints, errors, levels)

        order = run("order", ranked)
        if refiner and plan.embedded:
            most = max(len(order), 1)
            shares = [np.where(r < len(order), r / most, 2.0) for r in edge_ranks(order, levels)]
            ints = run("refine", lambda p: fit.staged(ints, shares))
        return Offsets(ints, steps, carriers(order, ints, levels))

    def _traced(self, V0, latents, before, steps, progress: Progress) -> list[np.ndarray]:
        progress(0.0, "Encoding")
        return traced_offsets(self.params, V0, latents, self.meshes[:-1], self.surface, before, steps)

    def _face_errors(self, V0: np.ndarray, latents: list, offsets: list | None) -> np.ndarray:
        """Distance to the input times share of the area, (m_L,), of the faces of the finest decode; it adds up to the mean."""
        if offsets is not None:
            offsets = [o.astype(np.float32)[:, None] for o in offsets]
        latents = [f.astype(np.float32) for f in latents]
        V = decode(NUMPY, self.params, NUMPY.array(V0), latents, self.meshes[:-1], offsets)[-1]
        distance, _, _ = self.surface.closest(V.astype(np.float64))
        return distance[self.levels[-1].F].mean(1) * self.area
