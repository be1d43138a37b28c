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
FULL = 0.98  # of a budget, where the adjustment of faces ends
AIM = 0.992  # of a budget, what the adjustment aims at
TRIES = 4
CANDIDATES = 2
ROUNDING = 0.25e4  # d_pm of rounding to a lattice of step 1, in 1e-4: the mean of |x| over half a step


@dataclass(frozen=True)
class Codec:
    """What is searched. family: control mesh of at most so many faces; most: of the largest; encode(control, bits);
    decode: the mesh of the bytes; bits: those to choose from, ascending."""

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
            log_faces = _line(np.log(budget), np.log(size), np.log(self.faces))
            faces = np.exp(np.clip(log_faces, np.log(4), np.log(codec.most)))
            error = np.exp(_line(np.log(faces), np.log(self.faces), np.log(self.error)))
            out.append((float(np.hypot(error, ROUNDING * 0.5**bits)), int(faces), bits))
        return sorted(out)


def _line(x: float, xs: np.ndarray, ys: np.ndarray) -> float:
    """Piecewise linear through (xs, ys), xs ascending, its ends prolonged."""
    if len(xs) == 1:
        return float(ys[0] + x - xs[0])
    i = int(np.clip(np.searchsorted(xs, x), 1, len(xs) - 1))
    return float(ys[i - 1] + (x - xs[i - 1]) * (ys[i] - ys[i - 1]) / max(xs[i] - xs[i - 1], 1e-9))


@dataclass(frozen=True)
class Candidate:
    """Bytes that fit a budget, and the setting that they were made with."""

    faces: int
    bits: int
    data: bytes


def fitted(codec: Codec, faces: int, bits: int, budget: int) -> Candidate | None:
    """The bytes nearest below the budget that a few adjustments of the number of faces find."""
    best, low, high = None, 0, codec.most + 1
    faces = max(faces, 4)
    for _ in range(TRIES):
        control = codec.family(faces)
        data = codec.encode(control, bits)
        if len(data) <= budget:
            low = faces
            if best is None or len(data) > len(best.data):
                best = Candidate(faces, bits, data)
            if len(data) >= FULL * budget or faces >= codec.most:
                break
        else:
            high = min(faces, high)
            if len(control.F) > faces + 1:  # it cannot go lower
                break
        guess = int(len(control.F) * AIM * budget / len(data))
        faces = guess if low < guess < high else (low + high) // 2
        if faces <= low or faces >= high:
            break
    return best


def candidates(case: Case, codec: Codec, budgets: tuple[int, ...]) -> list[list[Candidate]]:
    """For each budget what fits it, of the settings that promise least error; empty where nothing is so small."""
    ladder = _Ladder.of(case, codec, max(budgets))
    found = [[fitted(codec, n, b, size) for _, n, b in ladder.promise(codec, size)[:CANDIDATES]] for size in budgets]
    return [[c for c in some if c] for some in found]


def choose(case: Case, decode: Callable[[bytes], TriMesh], found: list[list[Candidate]]) -> list[Coded | None]:
    """For each budget the decoded candidate of least d_pm; None where there is none."""
    made: dict[bytes, tuple[float, Coded]] = {}
    for candidate in (c for some in found for c in some):
        if candidate.data in made:
            continue
        try:
            mesh = decode(candidate.data)
            label = f"{candidate.faces} faces, {candidate.bits} bits"
            made[candidate.data] = (case.d_pm(mesh), Coded(mesh, len(candidate.data), label))
        except MeshError:  # rounding left no surface, or one that cannot be subdivided
            continue
    out = []
    for some in found:
        here = [made[c.data] for c in some if c.data in made]
        out.append(min(here, key=lambda pair: pair[0])[1] if here else None)
    return out
