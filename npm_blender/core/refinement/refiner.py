"""Refinement: the base and the latents of one mesh, fitted by gradient descent through the fixed decoder.

The encoder gives a first guess; here the sender asks the receiver's decoder what each number does to this mesh. The
base comes first, so that the mesh without features is as good as it can be; then the latents that are sent, rounded and
with their bits in the loss. The offsets follow, see `offset_fit`.
"""

from functools import partial

import numpy as np

from .descent import NORMAL, Descent, Tensor

BASE_RATE = 0.01  # Adam's rate on base positions, over the mean edge length of the base
RATES = (0.15, 0.08)  # Adam's rates on latents: of the first level when it is fitted alone, and of all that follows
WHOLE = 0.4  # share of the steps that see all latents; the others see a prefix, early ones more often
ROUNDED = 0.6  # share of the steps after which the decoder sees rounded latents
BIT = 2e-5  # of the loss, which is about one for the mean error at the start, for a bit
ATTEMPTS = (  # until one brings the mesh nearer: what it starts from, weight of the normals, divisors to try
    (1.0, NORMAL, (1,)),
    (0.0, NORMAL, (1,)),
    (0.0, 0.0, (1, 2, 4)),
)
PRUNINGS = 3  # where no attempt does: rounds that leave out the latents that do harm
VISIBLE = 5e-3  # share of the error that an attempt must save to be the last


class Refiner(Descent):
    """Fits the base and the latents of one mesh; steps: gradient steps per stage (Adam: Kingma and Ba 2015).

    Minimizes, over points p of the decoded mesh with shares a of its area and over its faces f, the distances to the nearest
    points q of the input along the directions n to them, and how far the normals are off:
    sum a |(p - q) . n| / unit + NORMAL sum a_f |n_f - m_f|, and a little for sliding and for bits (see `descent`). Ours.

    >>> import numpy as np
    >>> from npm_blender.core import LodSettings, TriMesh, build_lod
    >>> from npm_blender.core.geometry import ClosestPoints
    >>> from npm_blender.core.mesh import hierarchy
    >>> from npm_blender.core.network import load_weights
    >>> from npm_blender.core.refinement import Refiner, Target
    >>> V, F = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    >>> mesh = TriMesh.from_arrays(V, F)
    >>> lod = build_lod(mesh, LodSettings(base_faces=4, levels=1))
    >>> levels, params = hierarchy(lod.F0, len(lod.V0), 1), load_weights().params
    >>> refiner = Refiner(params, Target(mesh, ClosestPoints(mesh), lod, levels), steps=1)
    >>> V0 = refiner.base(lod.V0, bits=6)
    >>> V0.shape, bool((V0 * 2**6 == np.rint(V0 * 2**6)).all())
    ((4, 3), True)
    """

    def base(self, V0: np.ndarray, bits: int | None = None) -> np.ndarray:
        """Base positions (n0, 3) float64 whose decode without features is nearest to the input, from V0.

        bits: of a coordinate; the positions are then multiples of 2**-bits, rounded so that the decode stays near.
        """
        leaf = self.B.array(V0).requires_grad_(True)
        none = [self.B.array(np.zeros((mesh.m, 8))) for mesh in self.meshes[:-1]]
        low = V0[self.B.numpy(self.meshes[0].F).reshape(-1, 3)]
        edge = float(np.linalg.norm(low[:, 0] - low[:, 1], axis=1).mean())

        def decode(depth: int, done: float) -> Tensor:
            V = leaf if bits is None else leaf + (self.torch.round(leaf * 2**bits) / 2**bits - leaf).detach()
            return self.decode(V, none, depth)

        self.minimize([leaf], BASE_RATE * edge, decode, coarse=True)
        self.stage += 1
        fitted = self.B.numpy(leaf).astype(np.float64)
        if bits is None:
            return fitted
        plain, fitted = (np.rint(V * 2.0**bits) / 2.0**bits for V in (V0, fitted))
        return min(plain, fitted, key=lambda V: self.distances(self.B.array(V), none)[2])

    def level_by_level(self, V0: np.ndarray, features: list[np.ndarray], scale: float) -> list[np.ndarray]:
        """Latents (m_i, 8) fitted one level after the other, each with the coarser ones in place, from the encoder's.

        A better guess than the encoder's, and one in which a level has taken what it can from the finer ones, so that
        the order of importance may be read off it. A level without any stays so. scale: of the rates, smaller for meshes
        that need little.
        """
        base = self.B.array(V0)
        done = [self.B.array(np.zeros(f.shape)) for f in features]
        for i, f in enumerate(features):
            if f.any():
                leaf = self.B.array(f.copy()).requires_grad_(True)
                values = [*done[:i], leaf, *done[i + 1 :]]
                self.minimize([leaf], scale * RATES[i > 0], partial(self._with_values, base, values))
                done[i] = leaf.detach()
        self.stage += 1
        return [self.B.numpy(f) for f in done]

    def _with_values(self, base: Tensor, values: list[Tensor], depth: int, _: float) -> Tensor:
        """The decode to a level, as `minimize` asks for it."""
        return self.decode(base, values, depth)

    def latents(
        self, V0: np.ndarray, features: list[np.ndarray], order: np.ndarray, steps: np.ndarray, scale: float
    ) -> list[np.ndarray]:
        """Integers (m_i, 8) of the latents in `order` (feature numbers), fitted and rounded; zeros elsewhere.

        steps (L,): quantization step of each level; scale: of the rates. Prefixes of the order are good too. If a fit
        ends farther from the input than the base alone, others are tried; zeros if none helps.
        """
        base = self.B.array(V0)
        sizes = [len(f) for f in features]
        rank = np.full(sum(sizes), len(order))
        rank[order] = np.arange(len(order))
        ranks = [self.B.array(r[:, None]) for r in np.split(rank, np.cumsum(sizes)[:-1])]
        ints = self._best(base, features, ranks, len(order), [float(s) for s in steps], scale * RATES[1])
        self.normal = NORMAL
        self.stage += 1
        if ints is None:
            return [np.zeros(f.shape, np.int32) for f in features]
        return [self.B.numpy(i).astype(np.int32) for i in ints]

    def _best(self, base: Tensor, features: list[Tensor], ranks: list[Tensor], count: int, steps: list[Tensor],
              rate: float) -> list[Tensor] | None:
        """Integers that bring the mesh nearer, of the first attempt that does so visibly.

        Where none does, each attempt is tried again with those latents only whose surroundings it brings nearer, and the
        best of all counts; None if nothing helps.
        """
        none = [self.B.array(np.zeros(f.shape)) for f in features]
        before = self.distances(base, none)
        tried: list[list[Tensor]] = []
        best: tuple[float, list[Tensor] | None] = before[2], None
        for share, self.normal, divisors in ATTEMPTS:
            found = self._attempt(base, [self.B.array(share * f) for f in features], ranks, count, steps, rate)
            for divisor in divisors:
                tried.append([self.torch.round(new / divisor) for new in found])
                error = self._error_with(base, tried[-1], steps, before)
                if error < (1 - VISIBLE) * before[2]:
                    return tried[-1]
                best = min(best, (error, tried[-1]), key=lambda pair: pair[0])
        for ints in tried:
            for _ in range(PRUNINGS):
                ints = self._pruned(base, ints, steps)
                best = min(best, (self._error_with(base, ints, steps, before), ints), key=lambda pair: pair[0])
        return best[1]

    def _pruned(self, base: Tensor, ints: list[Tensor], steps: list[Tensor]) -> list[Tensor]:
        """`ints` without the latents that leave their face and its neighbours farther from the input than none at all."""
        distance, area = self.face_errors(base, [0 * i for i in ints])
        after, area_after = self.face_errors(base, _values(ints, steps))
        saved = distance * area - after * area_after
        kept = []
        for new, mesh in zip(ints, self.meshes, strict=False):
            own = saved.reshape(mesh.m, -1).sum(1)
            across = self.B.numpy(mesh.opposite).reshape(-1, 3) // 3
            kept.append(new * self.B.array(own + own[across].sum(1) > 0)[:, None])
        return kept

    def _attempt(self, base: Tensor, first: list[Tensor], ranks: list[Tensor], count: int, steps: list[Tensor],
                 rate: float) -> list[Tensor]:
        """Integers of the latents with ranks below `count`, fitted from `first`; zeros elsewhere."""
        torch = self.torch
        masks = [r < count for r in ranks]
        leaves = [f.requires_grad_(True) for f in first]
        random = np.random.default_rng(count)

        def prefix(depth: int, done: float) -> Tensor:
            """Some steps see only a part of the latents, so that prefixes are good too."""
            cut = count if random.random() < WHOLE else 1 + int(count * random.random() ** 2)
            values = []
            for leaf, rank, step in zip(leaves, ranks, steps, strict=True):
                rounded = leaf + (torch.round(leaf / step) * step - leaf).detach()
                values.append((rounded if done > ROUNDED else leaf) * (rank < cut))
            return self.decode(base, values, depth)

        def cost() -> Tensor:
            bits = (torch.log2(1 + (x / s).abs()) * m for x, s, m in zip(leaves, steps, masks, strict=True))
            return BIT * sum(b.sum() for b in bits)

        self.minimize(leaves, rate, prefix, masks, coarse=True, cost=cost)
        return [torch.round(x.detach() / s) * m for x, s, m in zip(leaves, steps, masks, strict=True)]

    def _error_with(self, base: Tensor, ints: list[Tensor], steps: list[Tensor], before: tuple[float, float,
                    float]) -> float:
        """Mean distance of a decode with these integers; infinite if any measure is worse than `before`."""
        self.progress(min(1.0, (self.stage + 1) / self.total), "Refining")
        after = self.distances(base, _values(ints, steps))
        return after[2] if all(a < b for a, b in zip(after, before, strict=True)) else np.inf


def _values(ints: list[Tensor], steps: list[Tensor]) -> list[Tensor]:
    """Latents from their integers."""
    return [i * s for i, s in zip(ints, steps, strict=True)]
