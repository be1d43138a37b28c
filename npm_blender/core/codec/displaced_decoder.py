"""Vertices of a displaced surface, of any number of the numbers that have arrived."""
import numpy as np

from ..bitstream import DisplacedCoding, DisplacedNumbers, ParsedStream
from ..displacement import DisplacedSurface
from ..mesh import Level


class DisplacedDecoder:
    """The receiver's side of a displaced surface (see `displacement`); NumPy alone."""

    def __init__(self, stream: ParsedStream) -> None:
        """stream: of `DisplacedCoding`."""
        coding, details = stream.header.coding, stream.details
        assert isinstance(coding, DisplacedCoding) and isinstance(details, DisplacedNumbers)
        levels = stream.header.levels
        self._surface = DisplacedSurface(stream.F0, len(stream.grid), levels, coding.smooth, stream.sharp)
        self.features = stream.features  # that have arrived
        self._V0, self._table = stream.V0, details.table
        self._steps = np.stack([np.repeat(coding.steps(levels, s), np.diff(self._surface.first)) for s in range(coding.stages)]
                               ) if coding.stages else np.zeros((0, 0))
        stage, level = np.nonzero(details.coded)  # the blocks of numbers, as they arrive
        self._stage, self._first = stage, self._surface.first[level]
        sizes = np.diff(self._surface.first)[level]
        self._begin = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
        # numbers after which a level stays as it is
        self._most = [int(self._begin[np.searchsorted(stage, end)]) for end in (*coding.ends, coding.stages)]

    @property
    def levels(self) -> list[Level]:
        """Connectivity of all levels."""
        return self._surface.hierarchy

    @property
    def stops(self) -> tuple[int, ...]:
        """Numbers at the end of each stage."""
        ends = np.searchsorted(self._stage, np.unique(self._stage), side="right")
        return tuple(int(self._begin[end]) for end in ends)

    def scalars(self, features: int) -> int:
        """Numbers in the first features: a feature is one."""
        return features

    def vertices(self, features: int, level: int) -> np.ndarray:
        """Vertices (n, 3) float64 of a level with the first numbers, unit frame."""
        return self._surface.shown(self._V0, self._moves(min(features, self._most[level])), level)

    def _moves(self, features: int) -> np.ndarray:
        """How far each vertex (n,) moves."""
        out = np.zeros(int(self._surface.first[-1]))
        if not features:
            return out
        block = int(np.searchsorted(self._begin, features)) - 1
        stage, end = int(self._stage[block]), int(self._first[block] + features - self._begin[block])
        if stage:
            out += self._table[stage - 1] * self._steps[stage - 1]
        out[:end] = self._table[stage, :end] * self._steps[stage, :end]
        return out
