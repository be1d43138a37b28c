"""Streams of one input: bases of several sizes, the scheme that fits it, steps for a budget or in stages."""

from dataclasses import dataclass

import numpy as np

from npm_blender.core.bitstream import canonical_order
from npm_blender.core.decimation import decimate
from npm_blender.core.mesh import TriMesh

from .fit import Fit, Target
from .rates import Rate
from .shape import Scheme
from .stream import SMOOTHEST, STEP_UNIT, Settings, write

SMOOTH = (0, 4, 8)  # of SMOOTHEST, tried in turn
GROWTH = 22  # of GROWTH_UNIT
TRADE = 0.04  # price of a bit in squared steps
NEVER = 1e9  # a price at which nothing is sent
COARSEST = 116  # of Settings.step: 2**-7.25 = 66e-4
FINEST = 256


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


def fitted(mesh: TriMesh, target: Target, faces: int, levels: int, bits: int, smooth: tuple[int, ...] = SMOOTH) -> Base:
    """The base of about so many faces, under that of the schemes whose surface without detail is nearest to the input."""
    decimation = decimate(mesh, faces)
    order = canonical_order(decimation.F0, len(decimation.V0))
    V0, best, nearest = decimation.V0[order.vertices], None, np.inf
    for s in smooth:
        scheme = Scheme(order.F, len(V0), levels, s / SMOOTHEST)
        fit = Fit(target, scheme)
        d = np.zeros(int(scheme.first[-1]))
        V = fit.base(V0, d)
        found = Base(fit, fit.on_lattice(V, d, bits), bits, s)
        distance = fit.distance(found.V0, d)
        if best is None or distance < nearest:
            best, nearest = found, distance
    return best


@dataclass
class Point:
    """A stream of one stage, what it costs and how far it is from the input."""

    step: int
    value: np.ndarray
    rate: Rate | None
    data: bytes
    distance: float


def point(base: Base, step: int, start: Point | None, passes: int, trade: float = TRADE) -> Point:
    """Encode at a step, from the integers of another."""
    settings = base.settings(step)
    value, rate = base.none(), None
    if start is not None:
        value = np.rint(start.value * 2.0 ** ((step - start.step) / STEP_UNIT)).astype(np.int64)
        rate = start.rate
    steps = settings.steps(0)
    value, rate = base.fit.integers(base.V0, steps, value, np.zeros_like(value), trade, passes, rate)
    d = value * np.repeat(steps, np.diff(base.fit.scheme.first))
    return Point(step, value, rate, base.write(settings, value[None]), base.fit.distance(base.V0, d))


def sweep(base: Base, first: int, most: int, passes: int) -> list[Point]:
    """The base alone, then points with halving steps, from Settings.step `first` until `most` bytes are exceeded."""
    out = [point(base, first - STEP_UNIT, None, 1, NEVER)]
    for step in range(first, FINEST + 1, STEP_UNIT):
        now = point(base, step, out[-1] if out[-1].value.any() else None, passes)
        out.append(now)
        if len(now.data) > most:
            break
    return out


def between(base: Base, points: list[Point], budget: int, passes: int) -> Point | None:
    """A point of at most `budget` bytes and little less, or None."""
    below = [p for p in points if len(p.data) <= budget]
    if not below:
        return None
    best = below[-1]
    above = points[len(below):len(below) + 1]
    if not above or len(best.data) > 0.97 * budget:
        return best
    low, high = np.log([len(best.data), len(above[0].data)])
    step = best.step + int((np.log(0.99 * budget) - low) / (high - low) * (above[0].step - best.step))
    for _ in range(3):
        if step <= best.step:
            break
        found = point(base, step, best if best.value.any() else None, passes)
        if len(found.data) <= budget:
            return found
        step -= max(1, int(np.ceil(STEP_UNIT * np.log2(len(found.data) / budget) * 1.3)))
    return best


def expected(points: list[Point], budget: int) -> float:
    """Logarithm of the distance that a budget should reach, infinite below the first point."""
    size = np.log([len(p.data) for p in points])
    if np.log(budget) < size[0]:
        return np.inf
    return float(np.interp(np.log(budget), size, np.log([max(p.distance, 1e-9) for p in points])))


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
