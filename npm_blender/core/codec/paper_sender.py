"""The paper's own stream: a base mesh and the encoder's latents, the most important first (paper sections 3.2 and 3.3)."""
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..bitstream import Header, LatentCoding, LatentFeatures, encode_base, quantize_positions, write_latents
from ..geometry import ClosestPoints
from ..levels import LodSequence
from ..mesh import Level, TriMesh
from ..network import FEATURES, NUMPY, MeshIndex, Weights, decode, encode
from .base_too_large import BaseTooLarge
from .importance import gain_order, magnitude_order, measured_gains, split_numbers
from .quantization import latent_steps, position_bits_for, step_scale
from .source_facts import SourceFacts
from .stage_clock import StageClock


@dataclass(frozen=True)
class Sequence:
    """What is sent of a mesh in the unit frame. mesh: the cleaned input; lod: its LoD sequence; levels: 0..L of `lod`;
    connectivity: bytes of the base faces."""

    mesh: TriMesh
    lod: LodSequence
    levels: list[Level]
    connectivity: bytes


class PaperSender:
    """What a mesh is sent as by the paper. All positions are in the unit frame."""

    def __init__(self, weights: Weights, sequence: Sequence, order: str, clock: StageClock) -> None:
        """order: of the latents, see `CompressSettings`."""
        self.weights, self.params, self.sequence, self.lod = weights, weights.params, sequence, sequence.lod
        self.levels, self.feature_levels, self.order, self.clock = sequence.levels, sequence.levels[:-1], order, clock
        self.meshes = [MeshIndex.of(NUMPY, level) for level in self.levels]
        self.surface = ClosestPoints(sequence.mesh)
        areas = TriMesh(self.lod.V, self.levels[-1].F).face_areas()
        self.area = areas / areas.sum()

    def send(self, source: SourceFacts, position_bits: int, budget: int) -> tuple[bytes, int]:
        """All steps: (stream, number of latents). budget: bytes, 0 for as many as all take.

        Raises BaseTooLarge where the budget does not pay for the base."""
        values = self._encode(self.lod.V0)
        error = self._error(self.lod.V0)
        bits = position_bits or position_bits_for(error)
        grid, V0 = quantize_positions(self.lod.V0, bits)
        base = encode_base(grid, self.lod.F0, self.sequence.connectivity)
        steps = latent_steps(self.lod.level_count, step_scale(error))
        ints = [np.rint(v / s).astype(np.int32) for v, s in zip(values, steps, strict=True)]
        order = self._order(V0, values)
        flat = np.concatenate(ints)
        order = order[flat[order].any(1)]
        level, face = split_numbers(order, self.feature_levels)
        coding = LatentCoding(self.weights.model_id, self.weights.digest, tuple(map(float, steps)), FEATURES)
        x, y, z = map(float, source.frame.centre)

        def stream(count: int) -> bytes:
            header = Header(self.lod.level_count, bits, count, source.faces, source.vertices, (x, y, z), source.frame.size,
                            coding)
            return write_latents(header, base, LatentFeatures(level[:count], face[:count], flat[order[:count]]))

        with self.clock.stage("write") as progress:
            progress(0.0, "Writing")
            if budget and len(stream(0)) > budget:
                raise BaseTooLarge(len(stream(0)), len(self.lod.F0), budget)
            count = _most(len(order), lambda count: not budget or len(stream(count)) <= budget)
            return stream(count), count

    def _encode(self, V0: np.ndarray) -> list[np.ndarray]:
        """The encoder's latents (m_i, 8) per level."""
        with self.clock.stage("encode") as progress:
            progress(0.0, "Encoding")
            Vs = [V0, *(self.lod.V[: level.n] for level in self.levels[1:])]
            return encode(NUMPY, self.params, [NUMPY.array(V) for V in Vs], self.meshes)

    def _decoded(self, V0: np.ndarray, latents: list[np.ndarray]) -> np.ndarray:
        return decode(NUMPY, self.params, NUMPY.array(V0), [v.astype(np.float32) for v in latents], self.meshes[:-1])[-1]

    def _error(self, V0: np.ndarray) -> float:
        """Mean distance of the finest level without latents to the source."""
        V = self._decoded(V0, [np.zeros((len(level.F), FEATURES)) for level in self.feature_levels])
        distance, _, _ = self.surface.closest(V.astype(np.float64))
        return max(float((distance[self.levels[-1].F].mean(1) * self.area).sum()), 1e-9)

    def _order(self, V0: np.ndarray, values: list[np.ndarray]) -> np.ndarray:
        """Numbers of the latents, the most important first (paper section 3.3)."""
        with self.clock.stage("order") as progress:
            progress(0.0, "Ordering features")
            flat = np.concatenate(values)
            if self.order == "magnitude":
                return magnitude_order(flat)
            errors = []
            for count in range(self.lod.level_count + 1):
                V = self._decoded(V0, [v if i < count else 0 * v for i, v in enumerate(values)])
                error = np.abs(((V - self.lod.V) * self.lod.N).sum(1))
                errors.append(error[self.levels[-1].F].mean(1) * self.area)
            return gain_order(flat, measured_gains(errors, self.feature_levels))


def _most(count: int, fits: Callable[[int], bool]) -> int:
    """The largest number up to `count` for which `fits`, which holds for fewer where it holds for more; else 0."""
    if fits(count):
        return count
    low, high = 0, count
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low
