"""The codec in bytes: settings, lengths of what follows, connectivity, base positions, then the integers of all stages."""

from dataclasses import dataclass

import numpy as np

from npm_blender.core.bitstream import (
    decode_connectivity,
    decode_positions,
    encode_connectivity,
    encode_positions,
    read_varint,
    write_varint,
)
from npm_blender.core.errors import StreamError
from npm_blender.core.mesh import TriMesh

from . import symbols
from .shape import Scheme

_FIELDS = 6
_MAX_LEVELS, _MAX_STAGES, _MAX_BITS = 6, 24, 20
SMOOTHEST, GROWTH_UNIT, STEP_UNIT = 8, 16, 16


@dataclass(frozen=True)
class Settings:
    """What the header says, all whole numbers.

    levels: subdivisions; smooth: of SMOOTHEST, see stencils.refinement; bits: of a base coordinate; step: the finest
    level's in the first stage is 2**(-step / STEP_UNIT); growth: each level's step is growth / GROWTH_UNIT times the
    coarser one's; stages: each halves the steps.
    """

    levels: int
    smooth: int
    bits: int
    step: int
    growth: int
    stages: int

    def steps(self, stage: int) -> np.ndarray:
        """Step of each level (levels + 1,) in a stage, unit frame."""
        finest = 2.0 ** (-self.step / STEP_UNIT - stage)
        return finest * (self.growth / GROWTH_UNIT) ** np.arange(-self.levels, 1.0)


def write(settings: Settings, F0: np.ndarray, ints: np.ndarray, near: np.ndarray, table: np.ndarray) -> bytes:
    """F0 (m0, 3) in canonical order; ints (n0, 3): base positions; near: symbols.neighbours; table (stages, n)."""
    connectivity, positions = encode_connectivity(F0), encode_positions(ints, F0)
    first = _first(F0, len(ints), settings.levels)
    fields = (settings.levels, settings.smooth, settings.bits, settings.step, settings.growth, settings.stages)
    head = b"".join(map(write_varint, (*fields, len(connectivity), len(positions))))
    return head + connectivity + positions + symbols.encode(table, near, first)


def read(data: bytes) -> TriMesh:
    """The mesh of a stream, or of any prefix of one past its base mesh.

    Raises StreamError if the data end before, or are no such stream.
    """
    numbers, at = [], 0
    try:
        for _ in range(_FIELDS + 2):
            value, at = read_varint(data, at)
            numbers.append(value)
    except EOFError:
        raise StreamError("Expected a whole header, found the end of the data; get more of it") from None
    s = Settings(*numbers[:_FIELDS])
    middle = at + numbers[-2]
    end = middle + numbers[-1]
    if s.levels > _MAX_LEVELS or s.smooth > SMOOTHEST or s.bits > _MAX_BITS or not s.growth or s.stages > _MAX_STAGES:
        raise StreamError(f"Expected the header of a subdivision codec, found {s}; this is other data")
    if len(data) < end:
        raise StreamError(f"Expected at least {end} bytes (the base mesh), found {len(data)}; get more of it")
    F0 = decode_connectivity(data[at:middle])
    V0 = decode_positions(data[middle:end], F0) * 2.0**-s.bits
    scheme = Scheme(F0, len(V0), s.levels, s.smooth / SMOOTHEST)
    table, certain = symbols.decode(data[end:], s.stages, symbols.neighbours(scheme.hierarchy), scheme.first)
    return TriMesh(scheme.build(V0, _arrived(s, scheme, table, certain))[0], scheme.hierarchy[-1].F)


def _arrived(s: Settings, scheme: Scheme, table: np.ndarray, certain: int) -> np.ndarray:
    """How far each vertex moves, (n,), by the first `certain` integers of table (stages, n)."""
    n = table.shape[1]
    stage = np.arange(n) + n * np.arange(s.stages)[:, None] < certain
    last = stage.sum(0) - 1
    value = np.where(last >= 0, table[np.maximum(last, 0), np.arange(n)], 0)
    of_level = np.repeat(s.steps(0), np.diff(scheme.first))
    return value * of_level * 2.0 ** -np.maximum(last, 0)


def _first(F0: np.ndarray, n0: int, levels: int) -> np.ndarray:
    return Scheme(F0, n0, levels, 0.0).first
