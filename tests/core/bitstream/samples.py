"""Small streams of both kinds, made of numbers drawn at random."""
from typing import NamedTuple

import numpy as np

from npm_blender.core.bitstream import (
    DisplacedCoding,
    EncodedBase,
    Header,
    LatentCoding,
    LatentFeatures,
    around,
    canonical_order,
    encode_base,
    encode_displacements,
    quantize_positions,
    write_displaced,
    write_latents,
)
from npm_blender.core.mesh import hierarchy
from tests.meshes.base_meshes import some_features, sphere

LOW = (1.0, -2.0, 0.1)


class Sample(NamedTuple):
    """A stream and what went in: features is a table (stages, n), or LatentFeatures; where: its numbers are in these chunks."""

    data: bytes
    header: Header
    base: EncodedBase
    grid: np.ndarray
    features: object


def some_base(across: int = 2, bits: int = 12) -> tuple[np.ndarray, EncodedBase]:
    """Lattice positions of a small sphere, and the base that they make."""
    V, F = sphere(across)
    order = canonical_order(F, len(V))
    grid, _ = quantize_positions(V[order.vertices], bits)
    return grid, encode_base(grid, order.F)


def some_table(first: np.ndarray, stages: int, rng: np.random.Generator, quiet: float = 0.3) -> np.ndarray:
    """Integers (stages, n) as a sender has them: coarse levels first, some levels of some stages without change."""
    table, value = np.zeros((stages, first[-1]), np.int64), np.zeros(first[-1], np.int64)
    for s in range(stages):
        value = 2 * value
        for level in range(len(first) - 1):
            if rng.random() >= quiet:
                n = first[level + 1] - first[level]
                change = np.rint(rng.laplace(0, 0.9, n) * (rng.random(n) < 0.7)).astype(np.int64)
                value[first[level]:first[level + 1]] += change
        table[s] = value
    return table


def displaced_sample(levels: int = 2, stages: int = 3, across: int = 2, seed: int = 0, smooth: int = 8,
                     table: np.ndarray | None = None) -> Sample:
    """A stream of a displaced surface."""
    rng = np.random.default_rng(seed)
    grid, base = some_base(across)
    lods = hierarchy(base.F0, len(grid), levels)
    first = np.array([0, *(level.n for level in lods)])
    table = some_table(first, stages, rng) if table is None else table
    payload, coded = encode_displacements(table, around(lods), first)
    ends = tuple(rng.integers(0, stages + 1, levels).tolist())
    coding = DisplacedCoding(smooth, 64, 22, stages, len(payload), ends)
    header = Header(levels, 12, coded.numbers, 100_000, 50_002, LOW, 2.5, coding)
    return Sample(write_displaced(header, base, payload), header, base, grid, table)


def latent_sample(features: int = 100, across: int = 3, seed: int = 0, model_id: str = "default",
                  weights_hash: bytes = b"\1\2\3\4\5\6\7\x08", steps: tuple = (0.1, 0.2, 0.4)) -> Sample:
    """A stream of latents."""
    grid, base = some_base(across)
    level, face, value = some_features(len(base.F0), len(steps), features, np.random.default_rng(seed))
    coding = LatentCoding(model_id, weights_hash, steps, 8)
    header = Header(len(steps), 12, len(level), 100_000, 50_002, LOW, 2.5, coding)
    latents = LatentFeatures(level, face, value)
    return Sample(write_latents(header, base, latents), header, base, grid, latents)
