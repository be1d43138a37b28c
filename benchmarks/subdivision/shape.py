"""From integers to vertices: subdivide, then move every vertex that is new along its normal."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from npm_blender.core.geometry import vertex_normals
from npm_blender.core.mesh import Level, TriMesh, hierarchy

from .stencils import refinement


@dataclass(frozen=True)
class Scheme:
    """Base faces F0 (m0, 3), subdivided `levels` times with `smooth` (see stencils.refinement)."""

    F0: np.ndarray
    n0: int
    levels: int
    smooth: float

    @cached_property
    def hierarchy(self) -> list[Level]:
        """Connectivity of levels 0..levels."""
        return hierarchy(self.F0, self.n0, self.levels)

    @cached_property
    def matrices(self) -> list[csr_matrix]:
        """From each level to the next."""
        return [refinement(level, self.smooth) for level in self.hierarchy[:-1]]

    @cached_property
    def first(self) -> np.ndarray:
        """Vertices first[l]..first[l + 1] - 1 are new at level l, (levels + 2,) int64."""
        return np.array([0, *(level.n for level in self.hierarchy)], np.int64)

    def with_smooth(self, smooth: float) -> "Scheme":
        """The same connectivity under another scheme."""
        out = Scheme(self.F0, self.n0, self.levels, smooth)
        out.__dict__["hierarchy"] = self.hierarchy
        return out

    def new_at(self, level: int) -> slice:
        """Vertices that are new at a level."""
        return slice(int(self.first[level]), int(self.first[level + 1]))

    def build(self, V0: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Vertices (n, 3) of the finest level, and the direction (n, 3) in which each vertex was moved.

        V0 (n0, 3): base vertices; d (n,): how far each vertex moves at the level where it is new, along the normal of
        the subdivided surface there.
        """
        X, N = V0, []
        for i, level in enumerate(self.hierarchy):
            if i:
                X = self.matrices[i - 1] @ X
            now = self.new_at(i)
            N.append(vertex_normals(TriMesh(X, level.F))[now])
            X[now] += d[now, None] * N[-1] if i else 0
            if i == 0:
                X = X + d[now, None] * N[-1]
        return X, np.concatenate(N)
