"""What a stream is made of, on the sender's side: all that is decided, and as many of its features as are to be written."""

from dataclasses import dataclass

import numpy as np

from ..bitstream import Header, write_stream
from ..mesh import Level, UnitFrame
from ..network import FEATURES, Weights
from .importance import offset_values, split_numbers


@dataclass(frozen=True)
class Offsets:
    """One pass: integers (e_i,) and steps (L,) per level, and the numbers of the faces that carry them, in order."""

    ints: list[np.ndarray]
    steps: np.ndarray
    order: np.ndarray


@dataclass(frozen=True)
class Contents:
    """A base mesh and features for it.

    levels: 0..L-1; frame: unit frame of the positions; source: faces and vertices of the input; grid (n0, 3): lattice
    positions of the base in `bits` bits; F0 (m0, 3) in canonical order; steps (L,) float32 and latents (m_i, 8): integers
    per level; order: numbers of the latents that are sent, the most important first; passes: the offsets that follow.
    """

    weights: Weights
    levels: list[Level]
    frame: UnitFrame
    source: tuple[int, int]
    grid: np.ndarray
    bits: int
    F0: np.ndarray
    steps: np.ndarray
    latents: list[np.ndarray]
    order: np.ndarray
    passes: tuple[Offsets, ...] = ()

    def stream(self, count: int | None = None) -> bytes:
        """The stream of the first `count` features, None for all; passes that these do not reach are left out."""
        total = sum(map(len, self.latents))
        before = np.cumsum([len(self.order), *(len(p.order) for p in self.passes)])
        passes = [p for p, first in zip(self.passes, before, strict=False) if count is None or first < count]
        numbers = np.concatenate([self.order, *((i + 1) * total + p.order for i, p in enumerate(passes))])[:count]
        values = [*self.latents, *(offset_values(p.ints, self.levels, FEATURES) for p in passes)]
        group, face = split_numbers(numbers, self.levels * (1 + len(passes)))
        header = Header(
            model_id=self.weights.model_id,
            weights_hash=self.weights.digest,
            levels=len(self.levels),
            position_bits=self.bits,
            feature_steps=tuple(map(float, np.concatenate([self.steps, *(p.steps for p in passes)]))),
            total_features=len(numbers),
            source_faces=self.source[0],
            source_vertices=self.source[1],
            centre=tuple(map(float, self.frame.centre)),
            size=self.frame.size,
        )
        return write_stream(header, self.grid, self.F0, group, face, np.concatenate(values)[numbers])

    def within(self, budget: int) -> tuple[bytes, int]:
        """The stream of as many features as fit into `budget` bytes, and their number; 0 bytes: all of them.

        A budget that is less than the base mesh is exceeded by it.
        """
        best, count = self.stream(), len(self.order) + sum(len(p.order) for p in self.passes)
        if not budget or len(best) <= budget:
            return best, count
        fits, beyond, best = 0, count, self.stream(0)
        while beyond - fits > 1:
            middle = (fits + beyond) // 2
            data = self.stream(middle)
            if len(data) <= budget:
                fits, best = middle, data
            else:
                beyond = middle
        return best, fits
