"""What a stream is made of, on the sender's side: all that is decided, and as many of its features as are to be written."""

from dataclasses import dataclass

import numpy as np

from ..bitstream import EncodedBase, Header, StreamWriter
from ..mesh import Level, UnitFrame
from ..network import FEATURES, Weights
from .importance import offset_values, split_numbers


@dataclass(frozen=True)
class SourceFacts:
    """What a stream says of the mesh that it was made from. frame: its unit frame; faces, vertices: of the input."""

    frame: UnitFrame
    faces: int
    vertices: int


@dataclass(frozen=True)
class Base:
    """A base mesh as it is sent. V0 (n0, 3) float64: positions, unit frame, multiples of 2**-bits; coded: these and the
    faces F0 (m0, 3), in canonical order, as bytes."""

    V0: np.ndarray
    bits: int
    coded: EncodedBase


@dataclass(frozen=True)
class Latents:
    """steps (L,) float32: quantization steps; ints (m_i, 8) per level; order: numbers of the latents that are sent, the most
    important first (see `importance`)."""

    steps: np.ndarray
    ints: list[np.ndarray]
    order: np.ndarray

    @property
    def values(self) -> list[np.ndarray]:
        """The latents (m_i, 8) per level as the receiver has them."""
        return [i * s for i, s in zip(self.ints, self.steps, strict=True)]


@dataclass(frozen=True)
class Offsets:
    """One pass: integers (e_i,) and steps (L,) per level, and the numbers of the faces that carry them, in order."""

    ints: list[np.ndarray]
    steps: np.ndarray
    order: np.ndarray


class Contents:
    """A base mesh and features for it: latents, then passes of offsets, which are added one by one.

    A stream of the first features leaves out the passes that these do not reach: its header names fewer groups, and its packets
    are coded for fewer. So there is one writer for each number of passes, made when it is first needed.
    """

    def __init__(self, weights: Weights, levels: list[Level], source: SourceFacts, base: Base, latents: Latents) -> None:
        """levels: 0..L-1."""
        self._weights, self._levels, self._source, self._base = weights, levels, source, base
        self._latents = latents
        self._passes: list[Offsets] = []
        self._writers: dict[int, StreamWriter] = {}  # by number of passes

    def add(self, offsets: Offsets) -> None:
        """Let a pass of offsets follow."""
        self._passes.append(offsets)

    @property
    def features(self) -> int:
        """How many features there are."""
        return len(self._latents.order) + sum(len(p.order) for p in self._passes)

    def size(self, count: int | None = None) -> int:
        """Bytes of the stream of the first `count` features, None for all."""
        return self._writer(count).size(count)

    def stream(self, count: int | None = None) -> bytes:
        """The stream of the first `count` features, None for all; passes that these do not reach are left out."""
        return self._writer(count).stream(count)

    def within(self, budget: int) -> tuple[bytes, int]:
        """The stream of as many features as fit into `budget` bytes, and their number; 0 bytes: all of them.

        A budget that is less than the base mesh is exceeded by it.
        """
        count = self.features
        if not budget or self.size() <= budget:
            return self.stream(), count
        fits, beyond = 0, count
        while beyond - fits > 1:
            middle = (fits + beyond) // 2
            if self.size(middle) <= budget:
                fits = middle
            else:
                beyond = middle
        return self.stream(fits), fits

    def _writer(self, count: int | None) -> StreamWriter:
        """The writer of streams of `count` features."""
        first = np.cumsum([len(self._latents.order), *(len(p.order) for p in self._passes)])[:-1]  # feature of each pass
        passes = len(first) if count is None else int((first < count).sum())
        if passes not in self._writers:
            self._writers[passes] = self._new_writer(self._passes[:passes])
        return self._writers[passes]

    def _new_writer(self, passes: list[Offsets]) -> StreamWriter:
        total = sum(map(len, self._latents.ints))
        numbers = np.concatenate([self._latents.order, *((i + 1) * total + p.order for i, p in enumerate(passes))])
        values = [*self._latents.ints, *(offset_values(p.ints, self._levels, FEATURES) for p in passes)]
        group, face = split_numbers(numbers, self._levels * (1 + len(passes)))
        x, y, z = self._source.frame.centre
        header = Header(
            model_id=self._weights.model_id,
            weights_hash=self._weights.digest,
            levels=len(self._levels),
            position_bits=self._base.bits,
            feature_steps=tuple(map(float, np.concatenate([self._latents.steps, *(p.steps for p in passes)]))),
            total_features=len(numbers),
            source_faces=self._source.faces,
            source_vertices=self._source.vertices,
            centre=(float(x), float(y), float(z)),
            size=self._source.frame.size,
        )
        return StreamWriter(header, self._base.coded, group, face, np.concatenate(values)[numbers])
