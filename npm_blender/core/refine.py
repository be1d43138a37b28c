"""Refinement: the base and the features of one mesh, fitted by gradient descent through the fixed decoder.

The encoder gives a first guess; here the sender asks the receiver's decoder what each number does to this mesh. The
base comes first, so that the mesh without features is as good as it can be; then the features, one stage of the order
of importance after the other, each given the rounded ones before it, so that every prefix is good and not only the
whole. Distances are to the nearest points of the input, not to fixed targets: sliding along the surface costs nothing.
This is the only module of the core that needs torch.
"""

import os
from dataclasses import dataclass

import numpy as np

from .features import STAGES
from .lod import LodSequence
from .mesh import TriMesh
from .operators import MeshIndex, face_normals
from .progress import Progress, no_progress
from .settings import ComputeSettings
from .subdivide import Level
from .surface import Surface

UNITS = (0.3e-4, 15e-4)  # bounds of the distance that counts as one: the mesh's own mean error at the start of a stage
TANGENTIAL = 0.005  # weight of the distance to the mapped points, which keeps the mesh from sliding and folding
NORMAL = 0.4  # weight of the normals
EFFORT = {400: 2}  # times more steps for a stage that decides much: its features were fitted beside others than it has now
COARSE_STEPS = 3  # times more steps for the base and for the first stage, on the level before the last, a quarter as dear
BASE_RATE = 0.01  # Adam's rate on base positions, over the mean edge length of the base
RATES = (0.15, 0.08)  # Adam's rates on features: of the first level when it is fitted alone, and of all that follows
WHOLE = 0.4  # share of a stage's steps that see all of it; the others see a prefix, early ones more often
ATTEMPTS = (  # at a stage, until one brings the mesh nearer: what it starts from, weight of the normals, divisors to try
    (1.0, NORMAL, (1,)),
    (0.0, NORMAL, (1,)),
    (0.0, 0.0, (1, 2, 4)),
)
PRUNINGS = 3  # where no attempt does: rounds that leave out the features that do harm
VISIBLE = 5e-3  # share of the error that an attempt must save to be the last
QUADRATURE = np.array([3, 3, 3, 8, 8, 8, 27]) / 60  # weights of corners, middles of sides and centre
THREADS = 4  # at most, and half of the cores: threads that wait for a busy core make a step twenty times slower
REQUERY = 10  # steps between searches for the nearest points


def _added(sent, news, steps) -> list:
    """Values of the features: those sent, and new integers on top."""
    return [a + b * float(s) for a, b, s in zip(sent, news, steps, strict=True)]


@dataclass(frozen=True)
class Target:
    """What the decoded mesh is compared with: the input mesh in the unit frame and its surface, its LoD sequence."""

    mesh: TriMesh
    surface: Surface
    lod: LodSequence
    levels: list[Level]


class Refiner:
    """Fits one mesh. All arrays in and out are NumPy; the unit frame throughout."""

    def __init__(
        self,
        params: dict,
        target: Target,
        steps: int,
        progress: Progress = no_progress,
        compute: ComputeSettings | None = None,
    ) -> None:
        """params: folded decoder parameters; steps: gradient steps per stage."""
        import torch

        from .network import map_tree
        from .torch_backend import TorchBackend, torch_device

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
        self.total = 2 + len(STAGES) + len(self.meshes) - 1
        self.stage = 0
        self.unit, self.normal = UNITS[1], NORMAL

    def _weights(self, target: Target, depth: int):
        """Shares of the area of the faces of a level, (m, 1), and their normals (m, 3)."""
        level = target.levels[depth]
        mesh = TriMesh(target.lod.V[: level.n], level.F)
        areas = mesh.face_areas()
        return self.B.array((areas / areas.sum())[:, None]), self.B.array(mesh.face_normals())

    def _decode(self, V0, features, depth):
        from .decoder import decode

        return decode(self.B, self.params, V0, features[:depth], self.meshes[:depth])[-1]

    def _points(self, V, depth):
        """What is held against the input: the vertices and the face centres, (n + m, 3)."""
        mesh = self.meshes[depth]
        return self.B.concat([V, self.B.take(V, mesh.F).reshape(mesh.m, 3, 3).sum(1) / 3], 0)

    def _nearest(self, V, depth):
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

    def _loss(self, V, nearest, depth):
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

    def _descend(self, leaves, rate, decode, masks=None, coarse=False, effort=1):
        """Adam with a falling rate on the leaves, against decode(depth, share done).

        masks: 1 where a leaf's entry may move; coarse: most steps on the level before the last; effort: times more steps.
        """
        torch = self.torch
        few = min(self.weights)
        depths = [self.depth] * (effort * self.steps)
        if coarse:
            depths = [few] * (COARSE_STEPS * self.steps) + depths[self.steps // 2 :]
        optimiser = torch.optim.Adam(leaves, lr=rate, betas=(0.9, 0.98))
        nearest = None
        for step, depth in enumerate(depths):
            done = step / len(depths)
            self.progress(min(1.0, (self.stage + done) / self.total), "Refining")
            optimiser.param_groups[0]["lr"] = rate * (1 - 0.95 * done)
            V = decode(depth, done)
            if step % REQUERY == 0 or depth != depths[step - 1]:
                nearest = self._nearest(V, depth)
            if step == 0:
                self.unit = min(max(float(self.B.numpy((nearest[3] * nearest[2]).sum())), UNITS[0]), UNITS[1])
            gradients = torch.autograd.grad(self._loss(V, nearest, depth), leaves, allow_unused=True)
            for leaf, gradient, mask in zip(leaves, gradients, masks or [1] * len(leaves), strict=True):
                leaf.grad = None if gradient is None else torch.nan_to_num(gradient) * mask
            optimiser.step()

    def base(self, V0: np.ndarray) -> np.ndarray:
        """Base positions (n0, 3) float64 whose decode without features is nearest to the input, from V0."""
        leaf = self.B.array(V0).requires_grad_(True)
        none = [self.B.array(np.zeros((mesh.m, 8))) for mesh in self.meshes[:-1]]
        low = V0[self.B.numpy(self.meshes[0].F).reshape(-1, 3)]
        edge = float(np.linalg.norm(low[:, 0] - low[:, 1], axis=1).mean())
        self._descend([leaf], BASE_RATE * edge, lambda depth, done: self._decode(leaf, none, depth), coarse=True)
        self.stage += 1
        return self.B.numpy(leaf).astype(np.float64)

    def level_by_level(self, V0: np.ndarray, features: list[np.ndarray], scale: float) -> list[np.ndarray]:
        """Features (m_i, 8) fitted one level after the other, each with the coarser ones in place, from the encoder's.

        A better guess than the encoder's, and one in which a level has taken what it can from the finer ones, so that
        the order of importance may be read off it. scale: of the rates, smaller for meshes that need little.
        """
        base = self.B.array(V0)
        done = [self.B.array(np.zeros(f.shape)) for f in features]
        for i, f in enumerate(features):
            leaf = self.B.array(f.copy()).requires_grad_(True)
            values = [*done[:i], leaf, *done[i + 1 :]]
            self._descend([leaf], scale * RATES[i > 0], lambda depth, _, f=values: self._decode(base, f, depth))
            done[i] = leaf.detach()
            self.stage += 1
        return [self.B.numpy(f) for f in done]

    def staged(
        self, V0: np.ndarray, features: list[np.ndarray], order: np.ndarray, steps: np.ndarray, scale: float
    ) -> list[np.ndarray]:
        """Integers (m_i, 8) of the features, fitted and rounded stage by stage along `order` (feature numbers).

        steps (L,): quantization step of each level; scale: of the rates. A stage that ends farther from the input
        than it began is tried in other ways, and left out if none helps.
        """
        base = self.B.array(V0)
        sizes = [len(f) for f in features]
        rank = np.full(sum(sizes), len(order))
        rank[order] = np.arange(len(order))
        ranks = [self.B.array(r[:, None]) for r in np.split(rank, np.cumsum(sizes)[:-1])]
        ints = [np.zeros(f.shape, np.int32) for f in features]
        start = 0
        for stop in (*(s for s in STAGES if s < len(order)), len(order)):
            sent = [self.B.array(i * s) for i, s in zip(ints, steps, strict=True)]
            better = self._best(base, sent, features, ranks, (start, stop), steps, scale * RATES[1])
            if better:
                ints = [i + self.B.numpy(new).astype(np.int32) for i, new in zip(ints, better, strict=True)]
            self.normal = NORMAL
            self.stage += 1
            start = stop
        return ints

    def _best(self, base, sent, features, ranks, span, steps, rate):
        """Rounded values of the features of a stage that bring the mesh nearer, of the first attempt that does so visibly.

        Where none does, each attempt is tried again with those features only whose surroundings it brings nearer, and
        the best of all counts; None if nothing helps.
        """
        before = self._distances(base, sent)
        tried, best = [], (before[2], None)
        for share, self.normal, divisors in ATTEMPTS:
            first = [self.B.array(share * f) for f in features]
            news = self._stage(base, sent, first, ranks, span, steps, rate)
            for divisor in divisors:
                tried.append([self.torch.round(new / divisor) for new in news])
                error = self._error_with(base, sent, tried[-1], steps, before)
                if error < (1 - VISIBLE) * before[2]:
                    return tried[-1]
                best = min(best, (error, tried[-1]), key=lambda pair: pair[0])
        for news in tried:
            for _ in range(PRUNINGS):
                news = self._pruned(base, sent, news, steps)
                best = min(best, (self._error_with(base, sent, news, steps, before), news), key=lambda pair: pair[0])
        return best[1]

    def _pruned(self, base, sent, news, steps):
        """`news` without the features that leave their face and its neighbours farther from the input than `sent`."""
        distance, area = self._face_errors(base, sent)
        after, area_after = self._face_errors(base, _added(sent, news, steps))
        saved = distance * area - after * area_after
        kept = []
        for new, mesh in zip(news, self.meshes, strict=False):
            own = saved.reshape(mesh.m, -1).sum(1)
            across = self.B.numpy(mesh.opposite).reshape(-1, 3) // 3
            kept.append(new * self.B.array(own + own[across].sum(1) > 0)[:, None])
        return kept

    def _stage(self, base, sent, first, ranks, span, steps, rate):
        """Rounded values of the features with ranks in span, fitted from `first` with `sent` in place; else zeros."""
        torch, (start, stop) = self.torch, span
        masks = [(r >= start) & (r < stop) for r in ranks]
        leaves = [f.requires_grad_(True) for f in first]
        random = np.random.default_rng(stop)

        def prefix(depth, done):
            """Some steps see only a part of the stage, so that prefixes that end inside it are good too."""
            cut = stop if random.random() < WHOLE else start + 1 + int((stop - start) * random.random() ** 2)
            values = []
            for s, leaf, r, size in zip(sent, leaves, ranks, steps, strict=True):
                rounded = leaf + (torch.round(leaf / float(size)) * float(size) - leaf).detach()
                values.append(s + (rounded if done > 0.6 else leaf) * ((r >= start) & (r < cut)))
            return self._decode(base, values, depth)

        self._descend(leaves, rate, prefix, masks, coarse=start == 0, effort=EFFORT.get(stop, 1))
        return [torch.round(x.detach() / float(s)) * m for x, s, m in zip(leaves, steps, masks, strict=True)]

    def _error_with(self, base, sent, news, steps, before) -> float:
        """Mean distance of a decode with the new integers on top of what is sent; infinite if any measure got worse."""
        self.progress(min(1.0, (self.stage + 1) / self.total), "Refining")
        after = self._distances(base, _added(sent, news, steps))
        return after[2] if all(a < b for a, b in zip(after, before, strict=True)) else np.inf

    def _face_errors(self, base, values) -> tuple[np.ndarray, np.ndarray]:
        """Mean distance to the input and area of the faces of the finest decode, (m,) float64 each.

        A quadrature of degree three: the corners, the middles of the sides and the centre.
        """
        with self.torch.no_grad():
            V = self.B.numpy(self._decode(base, values, self.depth)).astype(np.float64)
        corners = V[self.B.numpy(self.meshes[self.depth].F).reshape(-1, 3)]
        points = np.concatenate([corners, (corners + np.roll(corners, -1, 1)) / 2, corners.mean(1, keepdims=True)], 1)
        distance, _, _ = self.surface.closest(points.reshape(-1, 3))
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        return distance.reshape(-1, 7) @ QUADRATURE, area

    def _distances(self, base, values) -> tuple[float, float, float]:
        """Mean distance of a decode to the input, by the area that is fitted, by the area shown, and that more exactly."""
        distance, area = self._face_errors(base, values)
        exact = float(distance @ area / area.sum())
        with self.torch.no_grad():
            V = self._decode(base, values, self.depth)
            _, _, share, distance = self._nearest(V, self.depth)
            _, area = face_normals(self.B, V, self.meshes[self.depth])
            corners = distance[: len(V)][self.meshes[self.depth].F].reshape(-1, 3).mean(1)
            shown = ((corners + distance[len(V) :]) / 2 * area[:, 0]).sum() / area.sum()
            return *map(float, self.B.numpy(self.torch.stack([(distance * share).sum(), shown]))), exact
