"""The flaps of a mesh: every edge with its two faces, seen from both ends, in a frame of its own.

A flap is the edge a-b with the third corners c and d of its two faces. It is two half-flaps: (a, b, c, d), and from the
other end (b, a, d, c). The frame has x along the edge, z the mean of the two face normals, y = z x x; the other
half-flap sees x and y negated, and the same z. On the border d is missing: c reflected through the middle of the edge
takes its place, with c's features, so that the flap is flat and the frame's z the normal of the only face.
"""

from dataclasses import dataclass

import numpy as np
import torch

from npm_blender.core.mesh import Level

# Squared lengths are bounded below, so that gradients stay finite: of edges, unit frame; of the cross product of two
# edges and of the sum of two unit normals, which are numbers.
EDGE_FLOOR, AREA_FLOOR, NORMAL_FLOOR = 1e-12, 1e-8, 1e-6


@dataclass(frozen=True)
class Flaps:
    """Connectivity of a level as tensors.

    a, b, c, d (e,) int64 corners of the flap of each edge, in the order of `Level.edges`; inner (e, 1) float: 0 on the
    border, else 1; first (2 e,) int64: the vertex at which each half-flap starts; corners (8 e,) int64: the four corners of
    each half-flap; share (n, 1) float: one over the number
    of half-flaps that start at a vertex; start, finish (r,) int64: pairs of neighbours that count for the differential
    coordinate of `start`, and weight (n, 1) float: one over their number. n: vertices.
    """

    n: int
    a: torch.Tensor
    b: torch.Tensor
    c: torch.Tensor
    d: torch.Tensor
    inner: torch.Tensor
    first: torch.Tensor
    corners: torch.Tensor
    share: torch.Tensor
    start: torch.Tensor
    finish: torch.Tensor
    weight: torch.Tensor

    @staticmethod
    def of(level: Level) -> "Flaps":
        """The flaps of a level."""
        flat = level.F.reshape(-1).astype(np.int64)
        left, right = level.edge_halfedge.astype(np.int64).T
        corner = [flat[h - h % 3 + (h + k) % 3] for h, k in ((left, 0), (left, 1), (left, 2), (right, 2))]
        border = left == right
        first = np.concatenate(corner[:2])
        # on the border, only neighbours along the border: a straight one then has no differential coordinate
        on_border = np.zeros(level.n, bool)
        on_border[np.concatenate([corner[0][border], corner[1][border]])] = True
        start, finish = first, np.concatenate([corner[1], corner[0]])
        counts = ~on_border[start] | np.tile(border, 2)
        start, finish = start[counts], finish[counts]
        return Flaps(
            level.n,
            *(torch.from_numpy(c) for c in corner),
            torch.from_numpy((~border).astype(np.float32)[:, None]),
            torch.from_numpy(first),
            torch.from_numpy(np.concatenate([np.stack(corner, 1), np.stack([corner[i] for i in (1, 0, 3, 2)], 1)]).reshape(-1)),
            _one_over_count(first, level.n),
            torch.from_numpy(start),
            torch.from_numpy(finish),
            _one_over_count(start, level.n),
        )


def _one_over_count(index: np.ndarray, n: int) -> torch.Tensor:
    return torch.from_numpy((1 / np.maximum(np.bincount(index, minlength=n), 1)).astype(np.float32)[:, None])


@dataclass(frozen=True)
class Frames:
    """Where the half-flaps are: x, y, z (e, 3) axes of each flap; unit (e, 1): mean length of its five edges.

    corners (2 e, 9): b, c, d from the start of each half-flap, in its frame and in units of `unit`.
    """

    x: torch.Tensor
    y: torch.Tensor
    z: torch.Tensor
    unit: torch.Tensor
    corners: torch.Tensor

    @staticmethod
    def of(V: torch.Tensor, flaps: Flaps) -> "Frames":
        """The frames of the flaps over positions V (n, 3)."""
        A, B, C, D = (V[i] for i in (flaps.a, flaps.b, flaps.c, flaps.d))
        D = flaps.inner * D + (1 - flaps.inner) * (A + B - C)
        sides = [B - A, C - A, D - A, C - B, D - B]
        unit = sum(map(length, sides)) / 5
        ab, ac, ad, bc, bd = (p / unit for p in sides)
        left, right = torch.linalg.cross(ab, ac), torch.linalg.cross(ad, ab)
        z = unit_vector(unit_vector(left, AREA_FLOOR) + unit_vector(right, AREA_FLOOR), NORMAL_FLOOR)
        x = unit_vector(ab, EDGE_FLOOR)
        y = torch.linalg.cross(z, x)
        there = [local(x, y, z, p) for p in (ab, ac, ad)]
        back = [turned(local(x, y, z, p)) for p in (-ab, bd, bc)]
        return Frames(x, y, z, unit, torch.cat([torch.cat(there, 1), torch.cat(back, 1)]))

    def world(self, moves: torch.Tensor) -> torch.Tensor:
        """Displacements (2 e, 3) from the frame and unit of each half-flap to the world, (2 e, 3)."""
        there, back = moves.chunk(2)
        return torch.cat([self._world(there), self._world(turned(back))])

    def _world(self, p: torch.Tensor) -> torch.Tensor:
        return self.unit * (self.x * p[:, :1] + self.y * p[:, 1:2] + self.z * p[:, 2:])


def local(x, y, z, p):
    """Vectors p (e, 3) in the frames x, y, z (e, 3)."""
    return torch.stack([(x * p).sum(1), (y * p).sum(1), (z * p).sum(1)], 1)


def turned(p):
    """Vectors (e, 3) of a flap's frame as the half-flap from the other end sees them, and the other way round."""
    return torch.cat([-p[:, :2], p[:, 2:]], 1)


def length(p):
    """Euclidean norm of rows (m, 3) -> (m, 1), bounded below."""
    return p.square().sum(1, keepdim=True).clamp(min=EDGE_FLOOR).sqrt()


def unit_vector(p, floor):
    """Rows (m, 3) divided by their length, whose square is bounded below by `floor`."""
    return p / p.square().sum(1, keepdim=True).clamp(min=floor).sqrt()


def ring_mean(x: torch.Tensor, flaps: Flaps) -> torch.Tensor:
    """Mean (n, C) over the half-flaps that start at each vertex, of x (2 e, C)."""
    return torch.zeros(flaps.n, x.shape[1], dtype=x.dtype).index_add(0, flaps.first, x) * flaps.share


def edge_mean(x: torch.Tensor) -> torch.Tensor:
    """Mean (e, C) over the two half-flaps of each edge, of x (2 e, C)."""
    there, back = x.chunk(2)
    return (there + back) / 2


def differential(V: torch.Tensor, flaps: Flaps) -> torch.Tensor:
    """Differential coordinates (n, 3): each vertex of V (n, 3) minus the mean of its neighbours."""
    return V - torch.zeros_like(V).index_add(0, flaps.start, V[flaps.finish]) * flaps.weight


__all__ = ["Flaps", "Frames", "differential", "edge_mean", "local", "ring_mean", "turned"]
