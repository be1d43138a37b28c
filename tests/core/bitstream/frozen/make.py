"""Writes the streams beside it that must open for ever: `python -m tests.core.bitstream.frozen.make`.

Run it once when a version of the format is new, never to make a test pass.
"""
from pathlib import Path

import numpy as np

from npm_blender.core.bitstream.container import VERSION
from npm_blender.core.mesh import hierarchy
from tests.core.bitstream.samples import Sample, displaced_sample, latent_sample, some_base

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


def main() -> None:
    """Both kinds, named by the version."""
    for name, sample in (("displaced", displaced()), ("latents", latents())):
        path = FOLDER / f"{name}_{VERSION}.npmesh"
        path.write_bytes(sample.data)
        print(path, len(sample.data))  # noqa: T201


if __name__ == "__main__":
    main()
