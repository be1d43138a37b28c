"""Gradient descent through the fixed decoder, and how far its meshes are from the input.

Distances are to the nearest points of the input, not to fixed targets: sliding along the surface costs nothing. With
`refiner` and `offset_fit`, which say what is fitted, this is all of the core that needs torch.
"""

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from ..errors import DependencyError
from ..geometry import ClosestPoints
from ..levels import LodSequence
from ..mesh import Level, TriMesh
from ..network import MeshIndex, face_normals
from ..progress import Progress, no_progress
from ..settings import ComputeSettings

Tensor: TypeAlias = Any  # a torch tensor; torch is loaded only where something is refined

UNITS = (0.3e-4, 15e-4)  # bounds of the distance that counts as one: the mesh's own mean error at the start of a stage
TANGENTIAL = 0.005  # weight of the distance to the mapped points, which keeps the mesh from sliding and folding
NORMAL = 0.4  # weight of the normals
COARSE_STEPS = 3  # times more steps for the base and for the first stage, on the level before the last, a quarter as dear
QUADRATURE = np.array([3, 3, 3, 8, 8, 8, 27]) / 60  # weights of corners, middles of sides and centre
THREADS = 4  # at most, and half of the cores: threads that wait for a busy core make a step twenty times slower
REQUERY = 10  # steps between searches for the nearest points


@dataclass(frozen=True)
class Target:
    """What the decoded mesh is compared with: the input mesh in the unit frame and its surface, its LoD sequence.

    levels: 0..L of the sequence.

    >>> from npm_blender.core import LodSettings, TriMesh, build_lod
    >>> from npm_blender.core.geometry import ClosestPoints
    >>> from npm_blender.core.mesh import hierarchy
    >>> from npm_blender.core.refinement import Target
    >>> V, F = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    >>> mesh = TriMesh.from_arrays(V, F)
    >>> lod = build_lod(mesh, LodSettings(base_faces=4, levels=1))
    >>> target = Target(mesh, ClosestPoints(mesh), lod, hierarchy(lod.F0, len(lod.V0), 1))
    >>> target.surface.closest(target.lod.V)[0].max() < 1e-6
    True
    """

    mesh: TriMesh
    surface: ClosestPoints
    lod: LodSequence
    levels: list[Level]


class Descent:
    """The decoder of one mesh in torch, its loss and its errors. All arrays in and out are NumPy; the unit frame throughout.

    Leaves and decodes are tensors. stage, total: for the progress bar, set by what is fitted.
    """

    def __init__(
        self,
        params: dict,
        target: Target,
        steps: int,
        progress: Progress = no_progress,
        compute: ComputeSettings | None = None,
    ) -> None:
        """params: folded decoder parameters; steps: gradient steps per stage. Raises DependencyError."""
        try:
            import torch
        except (ImportError, OSError) as error:  # OSError: of the libraries that it needs
            found = " ".join(str(error).split())[:200]
            raise DependencyError(
                f"Expected torch to load, found: {found}; repair or remove it, or use 0 refine steps"
            ) from error

        from ..network import TorchBackend, map_tree, torch_device

        compute = compute or ComputeSettings()
        if compute.threads:
            torch.set_num_threads(compute.threads)
        elif "OMP_NUM_THREADS" not in os.environ:
            torch.set_num_threads(max(1, min(THREADS, (os.cpu_count() or 1) // 2)))
        self.torch, self.steps, self.progress = torch, steps, progress
        self.device = torch_device(compute.device)
        self.B = TorchBackend(self.device)
        self.params = map_tree(self.B.array, {"decoder": params["decoder"]})
        self.meshes = [MeshIndex.of(self.B, level) for level in target.levels]
        self.surface = target.surface
        self.source_normals = target.mesh.face_normals()
        self.anchor = self.B.array(target.lod.V)
        self.depth = len(target.levels) - 1
        self.weights = {d: self._weights(target, d) for d in {self.depth, max(1, self.depth - 1)}}
        self.stage, self.total = 0, 1
        self.unit, self.normal = UNITS[1], NORMAL

    def _weights(self, target: Target, depth: int) -> tuple[Tensor, Tensor]:
        """Shares of the area of the faces of a level, (m, 1), and their normals (m, 3)."""
        level = target.levels[depth]
        mesh = TriMesh(target.lod.V[: level.n], level.F)
        areas = mesh.face_areas()
        return self.B.array((areas / areas.sum())[:, None]), self.B.array(mesh.face_normals())

    def decode(self, V0: Tensor, features: list[Tensor], depth: int, offsets: list[Tensor] | None = None) -> Tensor:
        """Vertices (n, 3) of level `depth`, a tensor: what the receiver makes of base, latents and offsets."""
        from ..network import decode

        return decode(self.B, self.params, V0, features[:depth], self.meshes[:depth], offsets)[-1]

    def _points(self, V: Tensor, depth: int) -> Tensor:
        """What is held against the input: the vertices and the face centres, (n + m, 3)."""
        mesh = self.meshes[depth]
        return self.B.concat([V, self.B.take(V, mesh.F).reshape(mesh.m, 3, 3).sum(1) / 3], 0)

    def _nearest(self, V: Tensor, depth: int) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """For the points of V: the nearest points of the input, the directions to them, and shares of the area.

        The area is the mean of the target's and of the decoded mesh's, so that a spike counts by the surface it shows.
        """
        torch, mesh = self.torch, self.meshes[depth]
        with torch.no_grad():
            P = self._points(V.detach(), depth)
            distance, point, face = self.surface.closest(self.B.numpy(P).astype(np.float64))
            away = P - self.B.array(point)
            far = self.B.array(distance)[:, None]
            direction = torch.where(far > 1e-6, away / far.clamp(min=1e-6), self.B.array(self.source_normals[face]))
            _, area = face_normals(self.B, V.detach(), mesh)
            share = (area / area.sum() + self.weights[depth][0]) / 2
            vertex = self.B.scatter_sum(torch.cat([share] * 3, 1).reshape(-1, 1) / 3, mesh.F, mesh.n)
            return self.B.array(point), direction, torch.cat([vertex, share])[:, 0] / 2, far[:, 0]

    def _loss(self, V: Tensor, nearest: tuple[Tensor, Tensor, Tensor, Tensor], depth: int) -> Tensor:
        torch = self.torch
        point, direction, share, _ = nearest
        face_share, normals = self.weights[depth]
        along = ((self._points(V, depth) - point) * direction).sum(1)
        aside = V - self.anchor[: len(V)]
        slide = (torch.sqrt((aside * aside).sum(1) + 1e-8) * share[: len(V)]).sum() * 2
        bend = face_normals(self.B, V, self.meshes[depth])[0] - normals
        bend = torch.sqrt((bend * bend).sum(1) + 1e-6)
        distance = (torch.sqrt(along * along + 1e-10) * share).sum()
        return (distance + TANGENTIAL * slide) / self.unit + self.normal * (bend * face_share[:, 0]).sum()

    def minimize(self, leaves: list[Tensor], rate: float, decode: Callable[[int, float], Tensor],
                masks: list[Tensor] | None = None,
                coarse: bool = False, effort: int = 1, cost: Callable[[], Tensor] | None = None) -> None:
        """Adam with a falling rate on the leaves, against decode(depth, share done).

        masks: 1 where a leaf's entry may move; coarse: most steps on the level before the last; effort: times more steps;
        cost: what the leaves cost beside what they save, or None.
        """
        torch = self.torch
        few = min(self.weights)
        depths = [self.depth] * (effort * self.steps)
        if coarse:
            depths = [few] * (COARSE_STEPS * self.steps) + depths[self.steps // 2 :]
        optimiser = torch.optim.Adam(leaves, lr=rate, betas=(0.9, 0.98))
        nearest: Any = None
        for step, depth in enumerate(depths):
            done = step / len(depths)
            self.progress(min(1.0, (self.stage + done) / self.total), "Refining")
            optimiser.param_groups[0]["lr"] = rate * (1 - 0.95 * done)
            V = decode(depth, done)
            if step % REQUERY == 0 or depth != depths[step - 1]:
                nearest = self._nearest(V, depth)
            if step == 0:
                self.unit = min(max(float(self.B.numpy((nearest[3] * nearest[2]).sum())), UNITS[0]), UNITS[1])
            loss = self._loss(V, nearest, depth)
            if cost is not None:
                loss = loss + cost()
            gradients = torch.autograd.grad(loss, leaves, allow_unused=True)
            for leaf, gradient, mask in zip(leaves, gradients, masks or [1] * len(leaves), strict=True):
                leaf.grad = None if gradient is None else torch.nan_to_num(gradient) * mask
            optimiser.step()

    def face_errors(self, base: Tensor, values: list[Tensor],
                    offsets: list[Tensor] | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Mean distance to the input and area of the faces of the finest decode, (m,) float64 each.

        A quadrature of degree three: the corners, the middles of the sides and the centre.
        """
        with self.torch.no_grad():
            V = self.B.numpy(self.decode(base, values, self.depth, offsets)).astype(np.float64)
        corners = V[self.B.numpy(self.meshes[self.depth].F).reshape(-1, 3)]
        points = np.concatenate([corners, (corners + np.roll(corners, -1, 1)) / 2, corners.mean(1, keepdims=True)], 1)
        distance, _, _ = self.surface.closest(points.reshape(-1, 3))
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        return distance.reshape(-1, 7) @ QUADRATURE, area

    def distances(self, base: Tensor, values: list[Tensor], offsets: list[Tensor] | None = None) -> tuple[float,
                  float, float]:
        """Mean distance of a decode to the input, by the area that is fitted, by the area shown, and that more exactly."""
        distance, area = self.face_errors(base, values, offsets)
        exact = float(distance @ area / max(area.sum(), 1e-30))
        with self.torch.no_grad():
            V = self.decode(base, values, self.depth, offsets)
            _, _, share, distance = self._nearest(V, self.depth)
            _, area = face_normals(self.B, V, self.meshes[self.depth])
            corners = distance[: len(V)][self.meshes[self.depth].F].reshape(-1, 3).mean(1)
            shown = ((corners + distance[len(V) :]) / 2 * area[:, 0]).sum() / area.sum()
            fitted, shown = map(float, self.B.numpy(self.torch.stack([(distance * share).sum(), shown])))
            return fitted, shown, exact
