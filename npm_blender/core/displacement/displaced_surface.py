"""From integers to vertices: subdivide, then move every vertex that is new along the normal of the surface there.

Displaced subdivision surfaces: Lee, Moreton, Hoppe 2000. NumPy alone: Blender's window walks this way.
"""
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..mesh import Level, Sharp, hierarchy
from .stencils import Stencil, stencil_of


class SurfaceLevels(NamedTuple):
    """What `DisplacedSurface.build` makes, one entry per level 0, 1, ..

    X: vertices (n_i, 3) float64; N: unit normals (k_i, 3) float64 along which those that are new at a level moved, of the surface
    before they did.

    >>> import numpy as np
    >>> from npm_blender.core.displacement import SurfaceLevels
    >>> built = SurfaceLevels(X=[np.eye(3)], N=[np.full((3, 3), 3**-0.5)])
    >>> len(built.X[-1])
    3
    """

    X: list[np.ndarray]
    N: list[np.ndarray]


AHEAD = 2  # levels further, at which the vertices of a level are looked at, see `DisplacedSurface.shown`


@dataclass(frozen=True)
class DisplacedSurface:
    """Base faces F0 (m0, 3) int over n0 vertices, subdivided `levels` times with `smooth`, 0..SMOOTHEST (see `stencil_of`).

    sharp: creases and corners of the base, which stay sharp under any scheme; None where it has none.

    A displaced subdivision surface (Lee, Moreton, Hoppe 2000), but with normals of the level where a vertex is new, and with
    displacements at every level: what is coarse is said once, at a coarse level. Vertices are numbered as in `hierarchy`.

    >>> import numpy as np
    >>> from npm_blender.core.displacement import DisplacedSurface
    >>> surface = DisplacedSurface(np.array([[0, 1, 2]]), n0=3, levels=1, smooth=0)
    >>> moves = np.array([0, 0, 0, 0.5, 0, 0])  # the first new vertex, on the first edge, goes up
    >>> surface.build(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), moves).X[1][3].tolist()
    [0.5, 0.0, 0.5]
    """

    F0: np.ndarray
    n0: int
    levels: int
    smooth: int
    sharp: Sharp | None = None

    @cached_property
    def hierarchy(self) -> list[Level]:
        """Connectivity of levels 0..levels."""
        return hierarchy(self.F0, self.n0, self.levels)

    @cached_property
    def stencils(self) -> list[Stencil]:
        """From each level to the next."""
        out, sharp = [], self.sharp
        for level in self.hierarchy[:-1]:
            out.append(stencil_of(level, self.smooth, sharp))
            sharp = sharp.subdivided(level) if sharp else None
        return out

    @cached_property
    def first(self) -> np.ndarray:
        """Vertices first[i]..first[i + 1] - 1 are new at level i, (levels + 2,) int64."""
        return np.array([0, *(level.n for level in self.hierarchy)], np.int64)

    def with_levels(self, levels: int) -> "DisplacedSurface":
        """The same surface of fewer levels."""
        out = replace(self, levels=levels)
        out.__dict__["hierarchy"] = self.hierarchy[: levels + 1]
        return out

    def new_at(self, level: int) -> slice:
        """Vertices that are new at a level."""
        return slice(int(self.first[level]), int(self.first[level + 1]))

    def shown(self, V0: np.ndarray, moves: np.ndarray, level: int) -> np.ndarray:
        """Vertices (n_level, 3) float64 of a level as it is shown: where they are AHEAD levels further, or at the finest.

        V0, moves: as for `build`. A smooth scheme goes on moving them; on a coarse level, they are the corners of a cage round
        the surface.
        """
        return self.shown_of(self.build(V0, moves, self._further(level)).X, level)

    def shown_of(self, X: list[np.ndarray], level: int) -> np.ndarray:
        """As `shown`, from the vertices of the levels that `build` gives."""
        return X[self._further(level)][: self.hierarchy[level].n]

    def _further(self, level: int) -> int:
        return min(level + AHEAD, self.levels) if self.smooth else level

    def build(self, V0: np.ndarray, moves: np.ndarray, level: int | None = None) -> SurfaceLevels:
        """Levels 0..level (None: the finest).

        V0 (n0, 3): base vertices; moves: how far each vertex goes along its normal at the level where it is new, in the unit of
        V0, one for each vertex of those levels at least.
        """
        X, out = V0, SurfaceLevels([], [])
        for i in range((self.levels if level is None else level) + 1):
            # of new vertices from the faces that they lie between, one level below
            N = _edge_normals(X, self.hierarchy[i - 1]) if i else _vertex_normals(X, self.F0)
            X = self.stencils[i - 1].apply(X) if i else X.astype(np.float64)
            new = self.new_at(i)
            moved = moves[new]
            if moved.any():
                X[new] += moved[:, None] * N
            out.X.append(X)
            out.N.append(N)
        return out


def _face_normals(X: np.ndarray, F: np.ndarray) -> np.ndarray:
    """Normals (m, 3), twice as long as the areas."""
    a, b, c = X[F[:, 0]], X[F[:, 1]], X[F[:, 2]]
    u, v = b - a, c - a
    out = np.empty_like(u)
    for x, y, z in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[:, x] = u[:, y] * v[:, z] - u[:, z] * v[:, y]
    return out


def _unit(N: np.ndarray) -> np.ndarray:
    return N / np.maximum(np.sqrt(N[:, :1] ** 2 + N[:, 1:2] ** 2 + N[:, 2:] ** 2), 1e-300)


def _edge_normals(X: np.ndarray, level: Level) -> np.ndarray:
    """Unit normals (e, 3) of the edges of a level, area-weighted over the faces at each; zero where they cancel out."""
    N = _face_normals(X, level.F)
    return _unit(N[level.edge_halfedge[:, 0] // 3] + N[level.edge_halfedge[:, 1] // 3])


def _vertex_normals(X: np.ndarray, F: np.ndarray) -> np.ndarray:
    """Unit normals (n, 3) of vertices, area-weighted; zero where the faces of a vertex cancel out."""
    N, flat = np.repeat(_face_normals(X, F), 3, axis=0), F.reshape(-1)
    return _unit(np.stack([np.bincount(flat, axis, len(X)) for axis in N.T], 1))
