"""Streams of one input: bases of several sizes, the scheme that fits it, steps for a budget or in stages."""

from dataclasses import dataclass

import numpy as np

from npm_blender.core.connectivity import canonical_order
from npm_blender.core.decimate import decimate
from npm_blender.core.mesh import TriMesh

from .fit import Fit, Rate, Target
from .shape import Scheme
from .stream import SMOOTHEST, Settings, write

SMOOTH = (0, 4, 8)  # of SMOOTHEST, tried in turn
GROWTH = 26
TRADE = 0.12  # price of a bit in squared steps; 0.1155 = 2 ln 2 / 12 balances a uniform quantizer
COARSEST = 33  # of Settings.step: 2**-8.25 = 33e-4


@dataclass
class Base:
    """A base mesh with its fitted lattice positions under a scheme."""

    fit: Fit
    ints: np.ndarray
    bits: int
    smooth: int

    @property
    def V0(self) -> np.ndarray:
        """Positions (n0, 3) as the receiver has them."""
        return self.ints * 2.0**-self.bits

    def settings(self, step: int, stages: int = 1) -> Settings:
        """For a first step."""
        return Settings(self.fit.scheme.levels, self.smooth, self.bits, step, GROWTH, stages)

    def none(self) -> np.ndarray:
        """No detail, (n,) int64."""
        return np.zeros(int(self.fit.scheme.first[-1]), np.int64)

    def write(self, settings: Settings, table: np.ndarray) -> bytes:
        """The stream of table (stages, n)."""
        return write(settings, self.fit.scheme.F0, self.ints, self.fit.near, table)


def bases(mesh: TriMesh, target: Target, sizes: tuple[tuple[int, int, int], ...]) -> list[Base]:
    """A base of each size (faces, levels, position bits), with the scheme that suits the first of them best."""
    out, smooth = [], SMOOTH
    for faces, levels, bits in sizes:
        decimation = decimate(mesh, faces)
        order = canonical_order(decimation.F0, len(decimation.V0))
        V0, best = decimation.V0[order.vertices], None
        for s in smooth:
            scheme = Scheme(order.F, len(V0), levels, s / SMOOTHEST)
            fit = Fit(target, scheme)
            d = np.zeros(int(scheme.first[-1]))
            V = fit.base(V0, d)
            found = Base(fit, fit.on_lattice(V, d, bits), bits, s)
            distance = fit.distance(found.V0, d)
            if best is None or distance < best[0]:
                best = (distance, found)
        out.append(best[1])
        smooth = (best[1].smooth,)
    return out


@dataclass
class Point:
    """A stream of one stage, what it costs and how far it is from the input."""

    step: int
    value: np.ndarray
    rate: Rate | None
    data: bytes
    distance: float


def point(base: Base, step: int, start: Point | None, passes: int) -> Point:
    """Encode at a step, from the integers of another."""
    settings = base.settings(step)
    value, rate = base.none(), None
    if start is not None:
        value = np.rint(start.value * 2.0 ** ((step - start.step) / 4)).astype(np.int64)
        rate = start.rate
    steps = settings.steps(0)
    value, rate = base.fit.integers(base.V0, steps, value, np.zeros_like(value), TRADE, passes, rate)
    d = value * np.repeat(steps, np.diff(base.fit.scheme.first))
    return Point(step, value, rate, base.write(settings, value[None]), base.fit.distance(base.V0, d))


def staged(base: Base, first: int, most: int, passes: int = 3) -> bytes:
    """One stream whose stages halve the steps until it has `most` bytes."""
    table, rate, data = [], None, b""
    value = base.none()
    while len(data) < most and len(table) < 16:
        old = 2 * value
        steps = base.settings(first).steps(len(table))
        value, rate = base.fit.integers(base.V0, steps, old, old, TRADE, passes, rate)
        table.append(value)
        data = base.write(base.settings(first, len(table)), np.array(table))
    return data
