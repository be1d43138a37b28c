"""The faces round each vertex of levels 1..L, in the order in which they lie, and what they measure."""
from typing import NamedTuple

import numpy as np

from ..geometry.normals import normal
from ..jit import compiled
from ..mesh.subdivision import Level

MARGIN = 0.05  # cosine between face and surface up to which a face counts as turned: the fit still moves it


class Rings(NamedTuple):
    """Levels 1..L in one: faces F (m, 3), concatenated; first (L + 1,): the first face of each level, and the end.

    around[at[k, v]:at[k, v + 1]]: the neighbours of v at level k + 1 in their order, none where v is fixed; faces, beside
    it: the face of v, that neighbour and the next. parents (n, 2): ends of the edge that a vertex halves, -1 for the base.
    fixed (n,): vertices that do not move, those of the border; n (L + 1,): number of vertices of each level from the base
    on, which come first.
    """

    F: np.ndarray
    first: np.ndarray
    at: np.ndarray
    around: np.ndarray
    faces: np.ndarray
    parents: np.ndarray
    fixed: np.ndarray
    n: np.ndarray


@compiled(allocates=True)
def _collect(F, opposite, first, fixed, at, around, faces):
    """The rings of one level, whose faces are numbered from `first` on; at (n + 1,) starts with the first free place."""
    n = len(at) - 1
    out = np.full(n, -1, np.int64)
    for f in range(len(F)):
        for c in range(3):
            out[F[f, c]] = 3 * f + c
    end = at[0]
    for v in range(n):
        h = start = out[v]
        while h >= 0 and not fixed[v]:
            around[end], faces[end] = F[h // 3, (h + 1) % 3], h // 3 + first
            end += 1
            h = opposite[h + 2 if h % 3 == 0 else h - 1]
            if h == start:
                break
        at[v + 1] = end


def rings_of(levels: list[Level]) -> Rings:
    """The rings of levels 1..L of a hierarchy (levels 0..L)."""
    n = np.array([level.n for level in levels])
    last = levels[-1]
    parents = np.full((last.n, 2), -1, np.int32)
    for level in levels[:-1]:
        parents[level.n:level.n + len(level.edges)] = level.edges
    fixed = np.zeros(last.n, bool)
    fixed[last.F.reshape(-1)[last.opposite == np.arange(last.F.size)]] = True
    levels = levels[1:]
    F = np.concatenate([level.F for level in levels])
    first = np.cumsum([0] + [len(level.F) for level in levels])
    at = np.zeros((len(levels), last.n + 1), np.int64)
    around, faces = np.empty(F.size, np.int32), np.empty(F.size, np.int32)
    for k, level in enumerate(levels):
        at[k, 0] = at[k - 1, -1] if k else 0
        _collect(level.F, level.opposite, first[k], fixed, at[k], around, faces)
    return Rings(F, first, at, around, faces, parents, fixed, n)


@compiled
def cosine(F, P, N, f):
    """Cosine between face f of points P and the sum of its corners' normals N."""
    a, b, c = F[f, 0], F[f, 1], F[f, 2]
    nx, ny, nz = normal(P, a, b, c)
    sx, sy, sz = N[a, 0] + N[b, 0] + N[c, 0], N[a, 1] + N[b, 1] + N[c, 1], N[a, 2] + N[b, 2] + N[c, 2]
    size = np.sqrt((nx * nx + ny * ny + nz * nz) * (sx * sx + sy * sy + sz * sz))
    return (nx * sx + ny * sy + nz * sz) / size if size > 1e-30 else 0.0


@compiled
def upright(product, size):
    """Whether a cosine is above MARGIN: product (of the vectors) over the root of size (the product of their squares)."""
    return product > 0.0 and size > 1e-60 and product * product > MARGIN * MARGIN * size


@compiled
def is_turned(F, P, N, f):
    """Whether the cosine of face f (see `cosine`) is at most MARGIN."""
    a, b, c = F[f, 0], F[f, 1], F[f, 2]
    nx, ny, nz = normal(P, a, b, c)
    sx, sy, sz = N[a, 0] + N[b, 0] + N[c, 0], N[a, 1] + N[b, 1] + N[c, 1], N[a, 2] + N[b, 2] + N[c, 2]
    return not upright(nx * sx + ny * sy + nz * sz,
                       (nx * nx + ny * ny + nz * nz) * (sx * sx + sy * sy + sz * sz))


@compiled
def measures(P, N, a, b, c):
    """Of the face a, b, c: product and size (see `upright`), and its bulge: how far its middle is from the planes of the
    surface at its corners, times its area (times 6). The product is its area projected on the surface at its corners (times 6),
    negative if it is turned."""
    ux, uy, uz = P[b, 0] - P[a, 0], P[b, 1] - P[a, 1], P[b, 2] - P[a, 2]
    vx, vy, vz = P[c, 0] - P[a, 0], P[c, 1] - P[a, 1], P[c, 2] - P[a, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    sx, sy, sz = N[a, 0] + N[b, 0] + N[c, 0], N[a, 1] + N[b, 1] + N[c, 1], N[a, 2] + N[b, 2] + N[c, 2]
    area = nx * nx + ny * ny + nz * nz
    height = (abs(N[a, 0] * (ux + vx) + N[a, 1] * (uy + vy) + N[a, 2] * (uz + vz))
              + abs(N[b, 0] * (vx - 2 * ux) + N[b, 1] * (vy - 2 * uy) + N[b, 2] * (vz - 2 * uz))
              + abs(N[c, 0] * (ux - 2 * vx) + N[c, 1] * (uy - 2 * vy) + N[c, 2] * (uz - 2 * vz))) / 3
    return nx * sx + ny * sy + nz * sz, area * (sx * sx + sy * sy + sz * sz), height * np.sqrt(area)
