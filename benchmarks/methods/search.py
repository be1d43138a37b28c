"""The best number of faces and of bits for a number of bytes, by d_pm, without trying them all.

Bytes and error are sampled on a coarse ladder of face counts and interpolated in logarithms; for each budget the two
settings that promise least error are made for real, their faces adjusted until the bytes fit, and measured.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from npm_blender.core.errors import MeshError
from npm_blender.core.mesh import TriMesh

from .case import Case, Coded

FIRST, RATIO = 100, 4  # faces of the ladder: 100, 400, 1600, ...
FULL = 0.985  # of a budget, where the adjustment of faces ends
TRIES = 4
CANDIDATES = 2
ROUNDING = 0.25e4  # d_pm of rounding to a lattice of step 1, in 1e-4: the mean of |x| over half a step


@dataclass(frozen=True)
class Codec:
    """What is searched. family: control mesh of at most so many faces; most: of the largest; encode(control, bits);
    decode: the mesh that is compared, from the bytes; bits: those to choose from, ascending."""

    family: Callable[[int], TriMesh]
    most: int
    encode: Callable[[TriMesh, int], bytes]
    decode: Callable[[bytes], TriMesh]
    bits: tuple[int, ...]


@dataclass(frozen=True)
class _Ladder:
    """faces (k,), error (k,) of the mesh with the most bits, size (bits, k) in bytes."""

    faces: np.ndarray
    error: np.ndarray
    size: np.ndarray

    @staticmethod
    def of(case: Case, codec: Codec, most_bytes: int) -> "_Ladder":
        """Rungs from FIRST up to the first that is too large at the fewest bits, or all the faces there are."""
        faces, error, size = [], [], []
        n = min(FIRST, codec.most)
        while True:
            control = codec.family(n)
            coded = [codec.encode(control, bits) for bits in codec.bits]
            if not faces or len(control.F) > faces[-1]:
                faces.append(len(control.F))
                error.append(max(case.d_pm(codec.decode(coded[-1])), 1e-6))
                size.append([len(data) for data in coded])
            if n >= codec.most or len(coded[0]) > most_bytes:
                return _Ladder(np.array(faces), np.array(error), np.array(size).T)
            n = min(n * RATIO, codec.most)

    def promise(self, codec: Codec, budget: int) -> list[tuple[float, int, int]]:
        """(error, faces, bits) for every number of bits, least error first."""
        out = []
        for bits, size in zip(codec.bits, self.size, strict=True):
            faces = np.exp(_line(np.log(budget), np.log(size), np.log(self.faces)))
            faces = min(faces, codec.most)
            error = np.exp(_line(np.log(faces), np.log(self.faces), np.log(self.error)))
            out.append((float(np.hypot(error, ROUNDING * 0.5**bits)), int(faces), bits))
        return sorted(out)


def _line(x: float, xs: np.ndarray, ys: np.ndarray) -> float:
    """Piecewise linear through (xs, ys), xs ascending, its ends prolonged."""
    if len(xs) == 1:
        return float(ys[0] + x - xs[0])
    i = int(np.clip(np.searchsorted(xs, x), 1, len(xs) - 1))
    return float(ys[i - 1] + (x - xs[i - 1]) * (ys[i] - ys[i - 1]) / max(xs[i] - xs[i - 1], 1e-9))


def _fitted(codec: Codec, faces: int, bits: int, budget: int) -> bytes | None:
    """The bytes nearest below the budget that a few adjustments of the number of faces find."""
    best, low, high = None, 0, codec.most + 1
    faces = max(faces, 4)
    for _ in range(TRIES):
        control = codec.family(faces)
        data = codec.encode(control, bits)
        if len(data) <= budget:
            low = faces
            if best is None or len(data) > len(best):
                best = data
            if len(data) >= FULL * budget or faces >= codec.most:
                break
        else:
            high = min(faces, high)
            if len(control.F) > faces + 1:  # it cannot go lower
                break
        guess = int(len(control.F) * 0.995 * budget / len(data))
        faces = guess if low < guess < high else (low + high) // 2
        if faces <= low or faces >= high:
            break
    return best


def best(case: Case, codec: Codec, budgets: tuple[int, ...]) -> list[Coded | None]:
    """For each budget the decoded mesh of least d_pm; None where no setting is so small."""
    ladder = _Ladder.of(case, codec, max(budgets))
    out = []
    for budget in budgets:
        found: list[tuple[float, Coded]] = []
        for _, faces, bits in ladder.promise(codec, budget)[:CANDIDATES]:
            data = _fitted(codec, faces, bits, budget)
            if data is None:
                continue
            mesh = codec.decode(data)
            try:
                found.append((case.d_pm(mesh), Coded(mesh, len(data), f"{bits} bits")))
            except MeshError:  # rounded to nothing
                continue
        out.append(min(found, key=lambda pair: pair[0])[1] if found else None)
    return out
