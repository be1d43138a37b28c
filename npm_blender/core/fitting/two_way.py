"""The distances between a surface and the source, both ways, as linear functions of what moves the surface.

Samples are the middles of the edges of the finest level, each with its closest point on the source, and points of the
source, each with its closest point on the surface. A sample's distance grows along the line between both, as long as that
line stays. Squares are weighted by distance ** -POWER: between plain squares and the sum that the error measures are.
"""
from typing import NamedTuple

import numpy as np

from ..displacement import DisplacedSurface
from ..geometry import ClosestPoints
from ..jit import compiled
from ..mesh import TriMesh
from .influence import Columns, Rows, columns_of
from .source import Source, closest, unit_vectors

POWER = 0.6


class Samples(NamedTuple):
    """k samples of both ways. corner (k, 3) int32, share (k, 3): the point of the surface, a mean of its vertices;
    away (k, 3) float32: the vector along which the weighted distance grows; distance (k,): weighted, too; weight (k,): of
    the square; rank (k,): places in a random order of each way; mean: the larger of both mean distances."""

    corner: np.ndarray
    share: np.ndarray
    away: np.ndarray
    distance: np.ndarray
    weight: np.ndarray
    rank: np.ndarray
    mean: float

    def part(self, count: int) -> "Samples":
        """`count` samples of each way, spread evenly."""
        if 2 * count >= len(self.distance):
            return self
        pick = np.flatnonzero(self.rank < count)
        return Samples(self.corner[pick], self.share[pick], self.away[pick], self.distance[pick], self.weight[pick],
                       self.rank[pick], self.mean)


class TwoWay:
    """A source, and a surface of some levels that shall come near it; unit frame.

    >>> import numpy as np
    >>> from npm_blender.core import TriMesh
    >>> from npm_blender.core.displacement import DisplacedSurface
    >>> from npm_blender.core.fitting import Source, TwoWay
    >>> square = TriMesh.from_arrays([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> fit = TwoWay(Source(square, 500), DisplacedSurface(square.F, 4, levels=1, smooth=0))
    >>> lifted = fit.surface.build(square.V + [0, 0, 0.1], np.zeros(9)).X[-1]
    >>> round(fit.measured(lifted, floor=1e-4, count=100).mean, 6)
    0.1
    """

    def __init__(self, source: Source, surface: DisplacedSurface) -> None:
        """surface: its finest level is what is measured."""
        self.source, self.surface = source, surface
        finest = surface.hierarchy[-1]
        self._rank = np.random.default_rng(0).permutation(len(finest.edges))
        self._tree: tuple[np.ndarray, ClosestPoints] | None = None
        # rows of the finest vertices over those that are new at each level
        rows, self.by_level = Rows.identity(finest.n), []
        for level in range(surface.levels, -1, -1):
            self.by_level.append(rows.without(int(surface.first[level])))
            if level:
                rows = rows.times(Rows(*surface.stencils[level - 1].rows(), surface.hierarchy[level - 1].n))
        self.by_level.reverse()

    def measured(self, X: np.ndarray, floor: float, count: int) -> Samples:
        """Of the finest vertices X (n, 3), `count` samples each way; distances below `floor` weigh no more."""
        finest, source = self.surface.hierarchy[-1], self.source
        F, count = finest.F, min(count, len(finest.edges), len(source.points))
        mine, theirs = np.flatnonzero(self._rank < count), np.flatnonzero(source.rank < count)
        edges = finest.edges[mine]
        middle = (X[edges[:, 0]] + X[edges[:, 1]]) / 2
        there, away = source.closest(middle)
        area = self._areas(X)[mine]
        area = area / max(area.sum(), 1e-300)
        points = source.points[theirs]
        back, at, face = closest(self.tree(X), points)
        share = _barycentric(X[F[face]], at)
        reverse = unit_vectors(at - points, back, source.normals[theirs])
        corner = np.concatenate([np.concatenate([edges, edges[:, :1]], 1), F[face]]).astype(np.int32)
        halves = np.tile([0.5, 0.5, 0.0], (len(edges), 1))
        weight = np.concatenate([area / np.maximum(there, floor) ** POWER, 1 / len(points) / np.maximum(back, floor) ** POWER])
        root = np.sqrt(weight)
        rank = np.concatenate([self._rank[mine], source.rank[theirs]])
        mean = max(float((area * there).sum()), float(back.mean()))
        return Samples(corner, np.concatenate([halves, share]), np.concatenate([away, reverse]) * root[:, None],
                       np.concatenate([there, back]) * root, weight, rank, mean)

    def columns(self, samples: Samples, level: int) -> Columns:
        """How the vertices that are new at a level move the samples."""
        return columns_of(self.by_level[level], samples.corner, samples.share)

    def moved(self, samples: Samples, level: int, moves: np.ndarray) -> Samples:
        """The samples after the vertices that are new at a level moved by `moves` (k, 3), as far as the model goes."""
        X = np.zeros((self.surface.hierarchy[level].n, 3))
        X[self.surface.new_at(level)] = moves
        for stencil in self.surface.stencils[level:]:
            X = stencil.apply(X)
        distance = samples.distance.copy()
        _shift(samples.corner, samples.share, samples.away, X, distance)
        return samples._replace(distance=distance)

    def _areas(self, X: np.ndarray) -> np.ndarray:
        """The area of the faces at each edge, (e,)."""
        finest = self.surface.hierarchy[-1]
        area = np.repeat(TriMesh(X, finest.F).face_areas(), 3)
        return np.bincount(finest.edge_of, area, len(finest.edges))

    def tree(self, X: np.ndarray) -> ClosestPoints:
        """The finest level with vertices X (n, 3), ready for queries; the last one is kept."""
        F = self.surface.hierarchy[-1].F
        if self._tree is None:
            self._tree = X, ClosestPoints(TriMesh(X, F))
        elif not np.array_equal(self._tree[0], X):
            self._tree = X, self._tree[1].moved(X, F)
        return self._tree[1]


def _barycentric(corners: np.ndarray, P: np.ndarray) -> np.ndarray:
    """Shares (k, 3) of the corners (k, 3, 3) in points P (k, 3) of their triangles."""
    u, v, p = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], P - corners[:, 0]
    uu, uv, vv = (u * u).sum(1), (u * v).sum(1), (v * v).sum(1)
    pu, pv = (p * u).sum(1), (p * v).sum(1)
    area = np.maximum(uu * vv - uv * uv, 1e-30)
    b, c = (vv * pu - uv * pv) / area, (uu * pv - uv * pu) / area
    return np.clip(np.stack([1 - b - c, b, c], 1), 0, 1)


@compiled
def _shift(corner, share, away, X, distance):
    for k in range(len(corner)):
        for c in range(3):
            v, w = corner[k, c], share[k, c]
            if w != 0:
                distance[k] += w * (X[v, 0] * away[k, 0] + X[v, 1] * away[k, 1] + X[v, 2] * away[k, 2])
