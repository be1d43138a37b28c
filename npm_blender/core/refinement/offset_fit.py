"""Offsets: how far the midpoints of edges are moved along their normals, on top of what the decoder predicts.

One integer an edge, where a latent feature is eight a face. They are fitted through the decoder, all levels at once and
with their bits in the loss, so that an edge keeps its zero where moving it saves less than it costs; then once more
along their order of importance, so that prefixes are good too.
"""

from collections.abc import Callable

import numpy as np

from .descent import Descent, Tensor

RATE = 0.3  # Adam's rate, in quantization steps
EFFORT = 2  # times more steps
WHOLE = 0.5  # share of the second fit's steps that see all offsets; the others see a prefix, early ones more often
ROUNDED = 0.6  # share of the steps after which the decoder sees rounded offsets


class OffsetFit:
    """Fits the offsets of one mesh on a base and latents that stay; ours.

    descent: of the mesh; V0 (n0, 3); latents: (m_i, 8) per level, as the receiver has them; sent: (e_i,) per level, the
    offsets of the pass before, unit frame; steps (L,): quantization steps, unit frame; bit: share of the loss for a bit. The
    loss is that of `Refiner`, plus bit sum_e log2(1 + |o_e|) for integers o_e.

    >>> import numpy as np
    >>> from npm_blender.core import LodSettings, TriMesh, build_lod
    >>> from npm_blender.core.geometry import ClosestPoints
    >>> from npm_blender.core.mesh import hierarchy
    >>> from npm_blender.core.network import load_weights
    >>> from npm_blender.core.refinement import OffsetFit, Refiner, Target
    >>> V, F = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    >>> mesh = TriMesh.from_arrays(V, F)
    >>> lod = build_lod(mesh, LodSettings(base_faces=4, levels=1))
    >>> levels, params = hierarchy(lod.F0, len(lod.V0), 1), load_weights().params
    >>> refiner = Refiner(params, Target(mesh, ClosestPoints(mesh), lod, levels), steps=1)
    >>> fit = OffsetFit(refiner, lod.V0, [np.zeros((4, 8))], [np.zeros(6)], np.array([0.01]), bit=1e-5)
    >>> [integers.shape for integers in fit.whole([np.zeros(6)])]
    [(6,)]
    """

    def __init__(
        self,
        descent: Descent,
        V0: np.ndarray,
        latents: list[np.ndarray],
        sent: list[np.ndarray],
        steps: np.ndarray,
        bit: float,
    ) -> None:
        B = descent.B
        self.descent, self.torch = descent, descent.torch
        self.base, self.latents = B.array(V0), [B.array(f) for f in latents]
        self.sent = [B.array(s[:, None]) for s in sent]
        self.steps, self.bit = [float(s) for s in steps], bit

    def whole(self, start: list[np.ndarray]) -> list[np.ndarray]:
        """Integers (e_i,) per level of a first fit, from `start`, which the order of importance may be read off."""
        return self._fit(start, lambda leaves, _: leaves)

    def staged(self, start: list[np.ndarray], ranks: list[np.ndarray]) -> list[np.ndarray]:
        """Integers (e_i,) per level, fitted from `start` so that prefixes of the order are good too.

        ranks (e_i,) per level: when an edge arrives, as a share 0..1 of all; 2 for an edge that never does. Zeros if the
        result is farther from the input than no offsets at all.
        """
        B, random = self.descent.B, np.random.default_rng(len(start))
        ranks = [B.array(r[:, None]) for r in ranks]

        def seen(leaves: list[Tensor], done: float) -> list[Tensor]:
            cut = 1.5 if random.random() < WHOLE else random.random() ** 2
            return [leaf * (rank < cut) for leaf, rank in zip(leaves, ranks, strict=True)]

        fitted = self._fit([s * (B.numpy(r)[:, 0] < 2) for s, r in zip(start, ranks, strict=True)], seen)
        fitted = [f * (B.numpy(r)[:, 0] < 2) for f, r in zip(fitted, ranks, strict=True)]
        return fitted if self.error(fitted) < self.error([0 * f for f in fitted]) else [0 * f for f in fitted]

    def error(self, offsets: list[np.ndarray]) -> float:
        """Mean distance of the decode to the input, unit frame. offsets: integers (e_i,) per level."""
        values = self._added([self.descent.B.array(o[:, None]) for o in offsets])
        return self.descent.distances(self.base, self.latents, values)[2]

    def _added(self, news: list[Tensor]) -> list[Tensor]:
        return [a + b * s for a, b, s in zip(self.sent, news, self.steps, strict=True)]

    def _fit(self, start: list[np.ndarray], seen: Callable[[list[Tensor], float], list[Tensor]]) -> list[np.ndarray]:
        torch, B = self.torch, self.descent.B
        leaves = [B.array(s[:, None]).requires_grad_(True) for s in start]

        def decode(depth: int, done: float) -> Tensor:
            values = seen(leaves, done)
            if done > ROUNDED:
                values = [v + (torch.round(v) - v).detach() for v in values]
            return self.descent.decode(self.base, self.latents, depth, self._added(values))

        def cost() -> Tensor:
            return self.bit * sum(torch.log2(1 + leaf.abs()).sum() for leaf in leaves)

        self.descent.minimize(leaves, RATE, decode, effort=EFFORT, cost=cost)
        self.descent.stage += 1
        return [np.rint(B.numpy(leaf)[:, 0]).astype(np.int32) for leaf in leaves]
