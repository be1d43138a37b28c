"""The sender: from a LoD sequence to the bytes of a stream.

The base and the latents first, then the offsets in passes, each finer than the one before. With torch all of them are
fitted through the decoder; without it the latents are the encoder's and the offsets are traced to the surface.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..bitstream import encode_base, quantize_positions
from ..geometry import ClosestPoints
from ..levels import LodSequence
from ..mesh import Level, TriMesh
from ..network import FEATURES, NUMPY, MeshIndex, Weights, decode, encode
from ..refinement import traced_offsets
from ..settings import CompressSettings, ComputeSettings
from .contents import Base, Contents, Latents, Offsets, SourceFacts
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

if TYPE_CHECKING:
    from ..refinement import Refiner  # loads torch


@dataclass(frozen=True)
class OffsetPass:
    """A pass over the offsets. step: quantization step on level 0, over the mean error of the mesh without offsets; bit:
    share of the loss for a bit, see `OffsetFit`; embedded: whether it starts from traced offsets and its prefixes are
    fitted too; a pass that finds little left to do starts from zeros, which leaves most edges out."""

    step: float
    bit: float
    embedded: bool


OFFSET_PASSES = (OffsetPass(0.5, 5e-5, True), OffsetPass(0.125, 1e-5, False))
STAGES = 4 + sum(1 + plan.embedded for plan in OFFSET_PASSES)  # fits through the decoder: base, latents twice, offsets


@dataclass(frozen=True)
class _Decoded:
    """What the receiver has before a pass. V0 (n0, 3); latents (m_i, 8) and offsets (e_i,) per level, unit frame."""

    V0: np.ndarray
    latents: list[np.ndarray]
    offsets: list[np.ndarray]


@dataclass(frozen=True)
class Sequence:
    """What is sent of a mesh in the unit frame. mesh: the cleaned input; lod: its LoD sequence; levels: 0..L of `lod`;
    connectivity: bytes of the base faces."""

    mesh: TriMesh
    lod: LodSequence
    levels: list[Level]
    connectivity: bytes


class Sender:
    """What a mesh is sent as. All positions are in the unit frame."""

    def __init__(
        self,
        weights: Weights,
        sequence: Sequence,
        settings: CompressSettings,
        compute: ComputeSettings,
        clock: StageClock,
    ) -> None:
        """settings: resolved, see `CompressSettings.resolved`; with 0 refine steps it does without torch."""
        self.weights, self.params, self.sequence, self.lod = weights, weights.params, sequence, sequence.lod
        self.levels, self.feature_levels, self.settings = sequence.levels, sequence.levels[:-1], settings
        self.compute, self.clock = compute, clock
        self.message = ""
        self.meshes = [MeshIndex.of(NUMPY, level) for level in self.levels]
        self.surface = ClosestPoints(sequence.mesh)
        areas = TriMesh(self.lod.V, self.levels[-1].F).face_areas()
        self.area = areas / areas.sum()

    def send(self, source: SourceFacts) -> tuple[bytes, int]:
        """All steps: (stream, number of features).

        Raises BaseTooLarge where the budget of the settings does not pay for the base mesh.
        """
        refiner = self._refiner() if self.settings.refine_steps else None
        base = self._base(refiner)
        self._check_budget(Contents(self.weights, self.feature_levels, source, base, self._nothing_sent()))
        latents = self._latents(refiner, base.V0)
        contents = Contents(self.weights, self.feature_levels, source, base, latents)
        self._add_offsets(refiner, contents, base.V0, latents.values)
        with self.clock.stage("write") as progress:
            progress(0.0, "Writing")
            return contents.within(self.settings.budget)

    def _check_budget(self, base_only: Contents) -> None:
        size, budget = base_only.size(), self.settings.budget
        if budget and size > budget:
            raise BaseTooLarge(size, len(self.lod.F0), budget)

    def _no_latents(self, kind: type) -> list[np.ndarray]:
        return [np.zeros((len(level.F), FEATURES), kind) for level in self.feature_levels]

    def _nothing_sent(self) -> Latents:
        return Latents(latent_steps(self.lod.level_count), self._no_latents(np.int32), np.zeros(0, np.int64))

    def _refiner(self) -> "Refiner":
        from ..refinement import Refiner, Target

        with self.clock.stage("refine") as progress:
            target = Target(self.sequence.mesh, self.surface, self.lod, self.levels)
            refiner = Refiner(self.params, target, self.settings.refine_steps or 0, progress, self.compute)
        refiner.total = STAGES
        if self.compute.device == "gpu" and refiner.device == "cpu":
            self.message = "refined on the processor, as torch finds no GPU"
        return refiner

    def _base(self, refiner: "Refiner | None") -> Base:
        """The base, fitted twice: freely, since its bits follow from what such a mesh is off by, and then on their lattice."""
        V0 = self.lod.V0
        if refiner:
            with self.clock.stage("refine"):
                V0 = refiner.base(V0)
        bits = self._position_bits(V0)
        if refiner:
            with self.clock.stage("refine"):
                V0 = refiner.base(V0, bits)
        grid, V0 = quantize_positions(V0, bits)
        return Base(V0, bits, encode_base(grid, self.lod.F0, self.sequence.connectivity))

    def _position_bits(self, V0: np.ndarray) -> int:
        """Bits of a coordinate that resolve what the mesh is off by anyway, at most those of the settings."""
        error = max(float(self._face_errors(V0, self._no_latents(np.float32), None).sum()), 1e-9)
        return int(np.clip(np.ceil(-np.log2(BASE_STEP * error)), LEAST_BITS, self.settings.position_bits))

    def _latents(self, refiner: "Refiner | None", V0: np.ndarray) -> Latents:
        """The latents that are sent, on a base with positions V0; with a refiner fitted level by level, then in their order."""
        values = self._encode(V0)
        scale = step_scale(float(self._face_errors(V0, [0 * v for v in values], None).sum()))
        steps = latent_steps(self.lod.level_count, scale)
        if refiner:
            with self.clock.stage("refine"):
                values = refiner.level_by_level(V0, values, scale)
        order = self._latent_order(V0, values)
        if refiner:
            with self.clock.stage("refine"):
                ints = refiner.latents(V0, values, order, steps, scale)
        else:
            ints = [np.rint(v / s).astype(np.int32) for v, s in zip(values, steps, strict=True)]
        flat, sent = np.concatenate(ints), np.zeros(sum(map(len, ints)), bool)
        sent[order] = True
        parts = np.split(flat * sent[:, None], first_numbers(self.feature_levels)[1:-1])
        return Latents(steps, parts, order[flat[order].any(1)])

    def _encode(self, V0: np.ndarray) -> list[np.ndarray]:
        """The encoder's latents (m_i, 8) per level, zeros on levels above the first that have enough faces."""
        with self.clock.stage("encode") as progress:
            progress(0.0, "Encoding")
            Vs = [V0, *(self.lod.V[: level.n] for level in self.levels[1:])]
            values = encode(NUMPY, self.params, [NUMPY.array(V) for V in Vs], self.meshes)
        enough = np.cumsum([len(v) for v in values]) >= LATENTS
        return [v * (i == 0 or not enough[i - 1]) for i, v in enumerate(values)]

    def _latent_order(self, V0: np.ndarray, values: list[np.ndarray]) -> np.ndarray:
        """Numbers of the latents that are sent, the most important first, at most LATENTS."""
        with self.clock.stage("order") as progress:
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

    def _add_offsets(self, refiner: "Refiner | None", contents: Contents, V0: np.ndarray, latents: list[np.ndarray]) -> None:
        """Pass after pass, each on top of the ones before, until the budget is full. latents: (m_i, 8) per level."""
        error = float(self._face_errors(V0, latents, None).sum())
        sent = [np.zeros(len(mesh.edge_a)) for mesh in self.meshes[:-1]]
        for plan in OFFSET_PASSES:
            found = self._offsets(refiner, _Decoded(V0, latents, sent), error, plan)
            contents.add(found)
            sent = [a + b * s for a, b, s in zip(sent, found.ints, found.steps, strict=True)]
            if self.settings.budget and contents.size() >= self.settings.budget:
                break

    def _offsets(self, refiner: "Refiner | None", before: _Decoded, error: float, plan: OffsetPass) -> Offsets:
        """One pass on top of what was sent before, for a mesh that is off by `error` without any offsets."""
        levels = self.feature_levels
        steps = (max(plan.step * error, LEAST_STEP) * GROWTH ** np.arange(len(levels))).astype(np.float32)
        if plan.embedded or not refiner:
            with self.clock.stage("encode") as progress:
                progress(0.0, "Encoding")
                ints = traced_offsets(self.params, before.V0, before.latents, self.meshes[:-1], self.surface,
                                      before.offsets, steps)
        else:
            ints = [0 * b for b in before.offsets]
        if refiner:
            from ..refinement import OffsetFit

            fit = OffsetFit(refiner, before.V0, before.latents, before.offsets, steps, plan.bit)
            with self.clock.stage("refine"):
                ints = fit.whole(ints)
        order = self._offset_order(before, ints, steps)
        if refiner and plan.embedded:
            most = max(len(order), 1)
            shares = [np.where(r < len(order), r / most, 2.0) for r in edge_ranks(order, levels)]
            with self.clock.stage("refine"):
                ints = fit.staged(ints, shares)
        return Offsets(ints, steps, carriers(order, ints, levels))

    def _offset_order(self, before: _Decoded, ints: list[np.ndarray], steps: np.ndarray) -> np.ndarray:
        """Numbers of the faces that have an offset to send, the most important first."""
        with self.clock.stage("order") as progress:
            progress(0.0, "Ordering features")
            errors = []
            for count in range(self.lod.level_count + 1):
                added = [o * s * (i < count) for i, (o, s) in enumerate(zip(ints, steps, strict=True))]
                offsets = [b + a for b, a in zip(before.offsets, added, strict=True)]
                errors.append(self._face_errors(before.V0, before.latents, offsets))
            return offset_order(ints, errors, self.feature_levels)

    def _face_errors(self, V0: np.ndarray, latents: list, offsets: list | None) -> np.ndarray:
        """Distance to the input times share of the area, (m_L,), of the faces of the finest decode; it adds up to the mean."""
        if offsets is not None:
            offsets = [o.astype(np.float32)[:, None] for o in offsets]
        latents = [f.astype(np.float32) for f in latents]
        V = decode(NUMPY, self.params, NUMPY.array(V0), latents, self.meshes[:-1], offsets)[-1]
        distance, _, _ = self.surface.closest(V.astype(np.float64))
        return distance[self.levels[-1].F].mean(1) * self.area
