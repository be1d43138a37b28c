"""Small streams of both kinds, made of numbers drawn at random."""
from typing import NamedTuple

import numpy as np

from npm_blender.core.bitstream import (
    DisplacedCoding,
    EncodedBase,
    Header,
    LatentCoding,
    LatentFeatures,
    Rung,
    around,
    canonical_order,
    encode_base,
    encode_displacements,
    quantize_positions,
    write_displaced,
    write_ladder,
    write_latents,
)
from npm_blender.core.mesh import Level, Sharp, hierarchy
from tests.meshes.base_meshes import some_features, sphere

LOW = (1.0, -2.0, 0.1)


class Sample(NamedTuple):
    """A stream and what went in: features is a table (stages, n), or LatentFeatures; payload: of a table."""

    data: bytes
    header: Header
    base: EncodedBase
    grid: np.ndarray
    features: object
    sharp: Sharp | None = None
    payload: bytes = b""

    @property
    def rung(self) -> Rung:
        """It as a rung of a ladder."""
        return Rung(self.header, self.base, self.payload)


class Ladder(NamedTuple):
    """A stream of rungs, and each of them alone."""

    data: bytes
    rungs: list[Sample]


def some_base(across: int = 2, bits: int = 12, sharp: Sharp | None = None) -> tuple[np.ndarray, EncodedBase]:
    """Lattice positions of a small sphere, and the base that they make."""
    V, F = sphere(across)
    order = canonical_order(F, len(V))
    grid, _ = quantize_positions(V[order.vertices], bits)
    return grid, encode_base(grid, order.F, sharp=sharp)


def chosen_sharp(level: Level, edges: np.ndarray, corners: np.ndarray) -> Sharp:
    """Creases and corners of a base where these are true and where they can be: at inner edges, and where two lines meet."""
    sharp = Sharp(edges & (level.edge_halfedge[:, 0] != level.edge_halfedge[:, 1]), corners)
    lines = np.bincount(level.edges[sharp.lines(level)].reshape(-1), minlength=level.n)
    return Sharp(sharp.edges, corners & (lines == 2))


def some_sharp(level: Level, rng: np.random.Generator, share: float = 0.3) -> Sharp:
    """Creases and corners drawn at random."""
    return chosen_sharp(level, rng.random(len(level.edges)) < share, rng.random(level.n) < 0.4)


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
                     table: np.ndarray | None = None, sharp: Sharp | None = None, bits: int = 12) -> Sample:
    """A stream of a displaced surface."""
    rng = np.random.default_rng(seed)
    grid, base = some_base(across, bits, sharp)
    lods = hierarchy(base.F0, len(grid), levels)
    first = np.array([0, *(level.n for level in lods)])
    table = some_table(first, stages, rng) if table is None else table
    payload, coded = encode_displacements(table, around(lods), first)
    ends = tuple(rng.integers(0, len(table) + 1, levels).tolist())
    coding = DisplacedCoding(smooth, 64, 22, len(table), len(payload), ends)
    header = Header(levels, bits, coded.numbers, 100_000, 50_002, LOW, 2.5, coding)
    return Sample(write_displaced(header, base, payload), header, base, grid, table, sharp, payload)


def base_level(across: int = 2) -> Level:
    """Connectivity of the base of `some_base`."""
    grid, base = some_base(across)
    return Level.of(base.F0, len(grid))


def creased_sample(across: int = 2, seed: int = 0, **given: object) -> Sample:
    """A stream whose base has creases and corners."""
    return displaced_sample(across=across, seed=seed, sharp=some_sharp(base_level(across), np.random.default_rng(seed)), **given)


def ladder_of(*rungs: Sample) -> Ladder:
    """The stream of these rungs."""
    return Ladder(write_ladder([sample.rung for sample in rungs]), list(rungs))


def ladder_sample() -> Ladder:
    """Three rungs: with levels, with creases and other bits, and a base alone."""
    return ladder_of(displaced_sample(levels=1, stages=2), creased_sample(seed=1, levels=1, stages=1, bits=14),
                     displaced_sample(levels=0, stages=0, across=3, smooth=0))


def latent_sample(features: int = 100, across: int = 3, seed: int = 0, model_id: str = "default",
                  weights_hash: bytes = b"\1\2\3\4\5\6\7\x08", steps: tuple = (0.1, 0.2, 0.4)) -> Sample:
    """A stream of latents."""
    grid, base = some_base(across)
    level, face, value = some_features(len(base.F0), len(steps), features, np.random.default_rng(seed))
    coding = LatentCoding(model_id, weights_hash, steps, 8)
    header = Header(len(steps), 12, len(level), 100_000, 50_002, LOW, 2.5, coding)
    latents = LatentFeatures(level, face, value)
    return Sample(write_latents(header, base, latents), header, base, grid, latents)
