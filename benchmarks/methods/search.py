"""The best number of faces and of bits for a number of bytes, by the error the worse way, without trying them all.

Bytes a face and error are sampled on a coarse ladder of face counts and interpolated; for each budget the settings that
promise least error are made for real, their faces adjusted until the bytes fit, and measured.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from npm_blender.core.errors import MeshError
from npm_blender.core.mesh import TriMesh

from .case import Case, Coded

FIRST, RATIO = 200, 4  # faces of the ladder: 200, 800, 3200, ...
ALMOST = 0.75  # of all faces
FULL = 0.98  # of a budget, where the adjustment of faces ends
AIM = 0.992  # of a budget, what the adjustment aims at
TRIES = 4
CANDIDATES = 3
CLOSE = 1.3  # the second and third candidate may promise this much more error than the first
ROUNDING = 0.25e4  # error of rounding to a lattice of step 1, in 1e-4: the mean of |x| over half a step


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
        """Rungs from FIRST up to the first that is too large at the fewest bits, or all the faces there are.

        The error falls steeply just below all faces, so there is a rung there.
        """
        faces, error, size = [], [], []
        rungs = [FIRST * RATIO**k for k in range(20) if FIRST * RATIO**k < codec.most / 2]
        for n in (*rungs, int(ALMOST * codec.most), codec.most):
            control = codec.family(n)
            coded = [codec.encode(control, bits) for bits in codec.bits]
            if not faces or len(control.F) > faces[-1]:
                faces.append(len(control.F))
                error.append(max(case.worse(codec.decode(coded[-1])), 1e-6))
                size.append([len(data) for data in coded])
            if len(coded[0]) > most_bytes:
                break
        return _Ladder(np.array(faces), np.array(error), np.array(size).T)

    def promise(self, codec: Codec, budget: int) -> list[tuple[float, int, int]]:
        """(error, faces, bits) of the best numbers of bits, least error first."""
        out = []
        n = np.geomspace(4, codec.most, 4_000)
        error = np.exp(_line(np.log(n), np.log(self.faces), np.log(self.error)))
        for bits, size in zip(codec.bits, self.size, strict=True):
            bytes_each = np.maximum(_line(np.log(n), np.log(self.faces), size / self.faces), 0.1)
            at = int(np.flatnonzero(n * bytes_each <= AIM * budget).max(initial=0))
            out.append((float(np.hypot(error[at], ROUNDING * 0.5**bits)), int(n[at] + 0.5), bits))
        out = sorted(out)
        return [one for one in out[:CANDIDATES] if one[0] <= CLOSE * out[0][0]]


def _line(x: np.ndarray, xs: np.ndarray, ys: np.ndarray) -> np.ndarray:
    """Piecewise linear through (xs, ys), xs ascending, its ends prolonged; constant if there is one point."""
    if len(xs) == 1:
        return np.full(len(x), float(ys[0]))
    i = np.clip(np.searchsorted(xs, x), 1, len(xs) - 1)
    return ys[i - 1] + (x - xs[i - 1]) * (ys[i] - ys[i - 1]) / (xs[i] - xs[i - 1])


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
    for attempt in range(2 * TRIES):
        if attempt >= TRIES and best:
            break
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
    """For each budget, ascending, the decoded candidate of least error the worse way; None where there is none.

    What fits a budget fits the larger ones too, and is chosen there where it is better than what was made for them.
    """
    made: dict[bytes, tuple[float, Coded]] = {}
    for candidate in (c for some in found for c in some):
        if candidate.data in made:
            continue
        try:
            mesh = decode(candidate.data)
            label = f"{candidate.faces} faces, {candidate.bits} bits"
            made[candidate.data] = (case.worse(mesh), Coded(mesh, len(candidate.data), label))
        except MeshError:  # rounding left no surface, or one that cannot be subdivided
            continue
    out, fit = [], []
    for some in found:
        fit += [made[c.data] for c in some if c.data in made]
        out.append(min(fit, key=lambda pair: pair[0])[1] if fit else None)
    return out
