"""Writes the streams beside it that must open for ever: `python -m tests.core.bitstream.frozen.make`.

Run it once when a version of the format is new, never to make a test pass.
"""
from pathlib import Path

import numpy as np

from npm_blender.core.bitstream.heads import VERSION
from npm_blender.core.mesh import hierarchy
from tests.core.bitstream.samples import (
    Ladder,
    Sample,
    base_level,
    chosen_sharp,
    displaced_sample,
    ladder_of,
    latent_sample,
    some_base,
)

FOLDER = Path(__file__).parent


def numbers() -> np.ndarray:
    """Integers (3, n) of the displaced stream, without a generator of random numbers."""
    grid, base = some_base()
    n = hierarchy(base.F0, len(grid), 2)[-1].n
    v, out = np.arange(n), np.zeros((3, n), np.int64)
    out[0] = (v * 7919 % 11 == 0) * (v % 3 - 1)
    out[1] = 2 * out[0] + (v * 104729 % 5 == 0) * (v % 5 - 2)
    out[2] = 2 * out[1] + (v >= len(grid)) * (v * 1299709 % 7 == 0) * (v % 9 - 4)
    return out


def latents() -> Sample:
    """A stream of 60 latents."""
    return latent_sample(60, across=2)


def displaced() -> Sample:
    """A stream of three stages on two levels."""
    return displaced_sample(table=numbers())


def ladder() -> Ladder:
    """A stream of two rungs, the second with creases and corners, fewer levels and more bits."""
    level = base_level(3)
    sharp = chosen_sharp(level, np.arange(len(level.edges)) % 5 < 2, np.arange(level.n) % 3 == 0)
    fine = level.n + len(level.edges)
    table = (np.arange(fine) * 7919 % 5 == 0) * (np.arange(fine) % 7 - 3)[None]
    return ladder_of(displaced(), displaced_sample(levels=1, across=3, table=table, sharp=sharp, bits=14))


def main() -> None:
    """All kinds, named by the version."""
    for name, sample in (("displaced", displaced()), ("latents", latents()), ("ladder", ladder())):
        path = FOLDER / f"{name}_{VERSION}.npmesh"
        path.write_bytes(sample.data)
        print(path, len(sample.data))  # noqa: T201


if __name__ == "__main__":
    main()
