"""The sender of a displaced surface: a fitted base, then integers stage by stage, each stage kept only if it helps.

All positions are in the unit frame, see `source_facts.lattice_frame`. Errors are the worse way: the larger of the mean
distances of both directions.
"""
from dataclasses import dataclass, replace

import numpy as np

from ..bitstream import (
    DisplacedCoding,
    EncodedBase,
    Header,
    around,
    displaced_size,
    encode_base,
    encode_displacements,
    order_connectivity,
    write_displaced,
)
from ..decimation import decimate
from ..displacement import SMOOTHEST, DisplacedSurface
from ..fitting import DetailFit, Rounding, Source, StageFit, TwoWay, default_rate, fit_base
from ..mesh import TriMesh
from ..progress import Progress, no_progress, part
from ..settings import AUTO
from .source_facts import SourceFacts

GROWTH = 22                     # steps from level to level, over GROWTH_UNIT
STEP_UNIT = 16
SCHEMES = (0, SMOOTHEST // 2, SMOOTHEST)
TRIED_LEVELS, FITTED_LEVELS = 2, 3  # at which schemes are compared, and the base of the best is fitted
TRIAL_PASSES, PASSES = 2, 3     # of a fit, while schemes are compared and after
MANY = 3000                     # faces of a base that is fitted at fewer levels
AIM, FULL, TRIES = 0.988, 0.972, 4  # of a budget: what is aimed at, what is full, how often it is tried
DEFAULT_FACES = 800             # of a base: about 0.8 kB
FINEST, FINER = 260_000, 12     # faces of the finest level at most, in all and over those of the source
STAGES = 14                     # at most
CHECKED = 20_000                # samples each way that errors are measured with
BETTER = 0.98                   # a stage that leaves more than this of the error ends the stream
SAME = 1.02                     # errors that differ by less are the same: samples
LEAST_ERROR = 2e-6              # nobody sees less
LEAST_BITS, MOST_BITS = 7, 20   # of a coordinate of the base
ROUNDED = 1.1                   # the error of a rounded base over that of the free one
FIRST_STEP = 2.0                # step of level 0 in the first stage, over the error of the base


@dataclass(frozen=True)
class FittedBase:
    """A base under a scheme. surface: of all levels; grid (n0, 3) int64: lattice positions; bits: of a coordinate; coded: as
    bytes; error: of the surface without details."""

    surface: DisplacedSurface
    grid: np.ndarray
    bits: int
    coded: EncodedBase
    error: float

    @property
    def V0(self) -> np.ndarray:
        """Base positions (n0, 3) as the receiver has them."""
        return self.grid * 2.0**-self.bits


class Target:
    """A mesh in the unit frame that is sent."""

    def __init__(self, mesh: TriMesh, facts: SourceFacts) -> None:
        self.mesh, self.facts, self.source = mesh, facts, Source(mesh)

    def error(self, surface: DisplacedSurface, V0: np.ndarray, moves: np.ndarray, level: int | None = None) -> float:
        """How far a level is from the mesh, the worse way."""
        level = surface.levels if level is None else level
        return self.source.error(TriMesh(surface.build(V0, moves, level).X[-1], surface.hierarchy[level].F), CHECKED)


def levels_for(faces: int, source_faces: int, most: int = 4) -> int:
    """Levels over a base of so many faces: up to `most`, as long as the finest is not much finer than the source."""
    count = most
    while count > 1 and (faces * 4**count > max(FINER * source_faces, 20_000) or faces * 4**count > FINEST):
        count -= 1
    return count


def default_faces(target: Target) -> int:
    """Faces of the base of a stream for all sizes."""
    return min(DEFAULT_FACES, len(target.mesh.F))


class FreeBase:
    """A base that is fitted to a target, under that of the schemes whose surface without details is nearest."""

    def __init__(self, target: Target, faces: int, levels: int, progress: Progress = no_progress, room: bool = True,
                 schemes: tuple[int, ...] = SCHEMES) -> None:
        """faces: about so many; levels: AUTO for as many as suit them; room: as in `decimate`."""
        self.target = target
        decimation = decimate(target.mesh, faces, 0, progress, room)
        self.message = decimation.message
        order, self.connectivity = order_connectivity(decimation.F0, len(decimation.V0))
        V0, n0 = decimation.V0[order.vertices], len(decimation.V0)
        self.faces = order.F
        levels = levels_for(len(order.F), len(target.mesh.F)) if levels == AUTO else levels
        best = None
        for smooth in schemes if levels > 0 else (0,):
            fit = TwoWay(target.source, DisplacedSurface(order.F, n0, min(max(levels, 0), TRIED_LEVELS), smooth))
            none = np.zeros(int(fit.surface.first[-1]))
            # the source itself needs no fit
            V = V0 if len(order.F) == len(target.mesh.F) and not smooth else fit_base(fit, V0, none, TRIAL_PASSES)
            error = target.error(fit.surface, V, none)
            if best is None or error < best[0]:
                best = error, fit, V
        assert best is not None
        self.error, self._fit, V0 = best
        if levels > TRIED_LEVELS and len(order.F) < MANY:
            self._fit = TwoWay(target.source, DisplacedSurface(order.F, n0, FITTED_LEVELS, self._fit.surface.smooth))
        if self.error > 0:
            none = np.zeros(int(self._fit.surface.first[-1]))
            V0 = fit_base(self._fit, V0, none, PASSES)
            self.error = target.error(self._fit.surface, V0, none)
        self._rounding = Rounding(self._fit, V0, np.zeros(int(self._fit.surface.first[-1])))
        self.surface = DisplacedSurface(order.F, n0, max(levels, 0), self._fit.surface.smooth)

    def rounded(self, bits: int) -> FittedBase:
        """The base on a lattice; bits: of a coordinate, 0 for as many as its error asks for."""
        none = np.zeros(int(self._fit.surface.first[-1]))
        for tried in range(bits or LEAST_BITS, (bits or MOST_BITS) + 1):
            grid = self._rounding.on_lattice(2.0**-tried)
            error = self.target.error(self._fit.surface, grid * 2.0**-tried, none)
            if error <= ROUNDED * max(self.error, LEAST_ERROR):
                break
        return FittedBase(self.surface, grid, tried, encode_base(grid, self.faces, self.connectivity), error)


class Stages:
    """Integers of a displaced surface on a base, stage after stage."""

    def __init__(self, target: Target, base: FittedBase) -> None:
        self.target, self.base = target, base
        self.near = around(base.surface.hierarchy)
        self.fit = DetailFit(target.source, base.surface, self.near)
        self.step = int(np.clip(round(-STEP_UNIT * np.log2(FIRST_STEP * max(base.error, LEAST_ERROR))), 0, 1023))
        self.values: list[np.ndarray] = []
        self.ends: tuple[int, ...] = ()
        self.errors = [base.error]
        self._last: StageFit | None = None

    def coding(self, step: int, stages: int, payload: int) -> DisplacedCoding:
        """Of a stream whose first stage has `step`."""
        ends = self.ends or (stages,) * self.base.surface.levels
        return DisplacedCoding(self.base.surface.smooth, step, GROWTH, stages, payload, ends)

    def error(self, value: np.ndarray, steps: np.ndarray) -> float:
        """How far integers (n,) with steps (levels + 1,) leave the finest level from the source."""
        return self.fit.error(self.base.V0, value * np.repeat(steps, np.diff(self.base.surface.first)), CHECKED)

    def add(self) -> float:
        """One stage more: what is left of the error. A stage that does not help stays empty."""
        surface, stage = self.base.surface, len(self.values)
        steps = self.coding(self.step, 1, 0).steps(surface.levels, stage)
        found = self.fit.stage(self.base.V0, steps, self._last, surface.levels, passes=2 if stage < 4 else 1)
        error = self.error(found.value, steps)
        if error > self.errors[-1]:
            kept = 2 * self.values[-1] if self.values else np.zeros_like(found.value)
            found, error = found._replace(value=kept), self.errors[-1]
        self._last = found
        self.values.append(found.value)
        self.errors.append(error)
        return error / max(self.errors[-2], 1e-12)

    def settle(self) -> int:
        """Decide after which stage each level but the finest stays as it is, so that more numbers are never farther off; and
        return the finest level up to which none is farther off than the one below."""
        surface, first = self.base.surface, self.base.surface.first
        errors = np.empty((len(self.values) + 1, surface.levels + 1))
        errors[:, -1] = self.errors
        for k in range(len(errors)):
            moves = np.zeros(int(first[-1]))
            if k:
                moves += self.values[k - 1] * np.repeat(self.coding(self.step, 1, 0).steps(surface.levels, k - 1), np.diff(first))
            for level in range(surface.levels):
                V = surface.shown(self.base.V0, moves, level)
                errors[k, level] = self.target.source.error(TriMesh(V, surface.hierarchy[level].F), CHECKED // 2)
        self.ends = tuple(_falling(errors[:, level]) for level in range(surface.levels))
        for level, end in enumerate(self.ends):
            errors[end:, level] = errors[end, level]
        fine = (errors[:, 1:] <= SAME * errors[:, :-1]).all(0)
        return surface.levels if fine.all() else int(np.argmin(fine))

    def leave_out(self, finest: int) -> None:
        """Levels above `finest`, with their numbers."""
        base = self.base
        n = int(base.surface.first[finest + 1])
        surface = DisplacedSurface(base.surface.F0, base.surface.n0, finest, base.surface.smooth)
        self.base, self.near = replace(base, surface=surface), self.near[:n]
        self.values, self.ends = [value[:n] for value in self.values], self.ends[:finest]

    def payload(self) -> bytes:
        """The bytes of all stages."""
        return encode_displacements(np.array(self.values), self.near, self.base.surface.first)[0]

    def stream(self, table: np.ndarray, step: int, payload: bytes | None = None, cut: int = 0) -> tuple[bytes, int]:
        """The stream of table (stages, n), and how many numbers it has; cut: bytes that it may have, 0 for all."""
        surface, facts = self.base.surface, self.target.facts
        data, coded = encode_displacements(table, self.near, surface.first)
        low = facts.frame.centre
        header = Header(surface.levels, self.base.bits, coded.count, facts.faces, facts.vertices,
                        (float(low[0]), float(low[1]), float(low[2])), facts.frame.size, self.coding(step, len(table), len(data)))
        if cut and displaced_size(header, self.base.coded, len(data)) > cut:
            room = len(data) - (displaced_size(header, self.base.coded, len(data)) - cut)
            k = int(np.searchsorted(coded.ends, max(room, 0), side="right")) - 1
            count = min(k * coded.group, coded.count)
            data = data[: int(coded.ends[k])]
            header = replace(header, total_features=count, coding=self.coding(step, len(table), len(data)))
        return write_displaced(header, self.base.coded, data), header.total_features


    def filled(self, budget: int) -> "Made":
        """The stream of one stage whose step fills a budget."""
        best = Made(*self.stream(self.nothing(), self.step), self.base.error, self.base)
        before, last = StageFit(np.zeros_like(self.near[:, 0], np.int64), default_rate(self.base.surface.levels), np.inf), best
        for stage in range(STAGES):
            found, now = self._one_stage(self.step + stage * STEP_UNIT, before, 2)
            if len(now.data) > budget:
                return self._between(best, last, now, self.step + (stage - 1) * STEP_UNIT, before, budget)
            if now.error > BETTER * last.error and len(now.data) > 1.2 * len(last.data):
                break
            before, last = found, now
            best = min(best, now, key=lambda one: one.error)
        return best

    def _one_stage(self, step: int, before: StageFit, scale: float) -> tuple[StageFit, "Made"]:
        """A stream of one stage, from the integers of another whose steps were `scale` times as large."""
        start = before._replace(value=np.rint(before.value * scale).astype(np.int64))
        steps = self.coding(step, 1, 0).steps(self.base.surface.levels, 0)
        found = self.fit.improved(self.base.V0, steps, start, np.zeros_like(start.value), self.base.surface.levels)
        return found, Made(*self.stream(found.value[None], step), self.error(found.value, steps), self.base)

    def _between(self, best: "Made", last: "Made", over: "Made", step: int, before: StageFit, budget: int) -> "Made":
        """The best of `best` and streams with steps between those of `last`, which fits the budget, and `over`."""
        low, high = 0, STEP_UNIT  # steps beyond `step` that fit, and that do not
        small, large = len(last.data), len(over.data)
        for _ in range(TRIES):
            share = (np.log(AIM * budget) - np.log(small)) / (np.log(large) - np.log(small))
            shift = min(max(low + round((high - low) * share), low + 1), high - 1)
            if high - low < 2:
                break
            _, now = self._one_stage(step + shift, before, 2.0 ** (shift / STEP_UNIT))
            if len(now.data) > budget:
                high, large = shift, len(now.data)
                continue
            best = min(best, now, key=lambda one: one.error)
            if len(now.data) > FULL * budget:
                break
            low, small = shift, len(now.data)
        return best

    @property
    def table(self) -> np.ndarray:
        """All stages (stages, n)."""
        return np.array(self.values) if self.values else self.nothing()

    def nothing(self) -> np.ndarray:
        """A table without stages."""
        return np.zeros((0, len(self.near)), np.int64)


def _falling(errors: np.ndarray) -> int:
    """The place up to which errors (k,) fall, or nearly stay."""
    least, end = errors[0], 0
    for k in range(1, len(errors)):
        if errors[k] > SAME * least:
            break
        if errors[k] <= least:
            least, end = errors[k], k
    return end


@dataclass(frozen=True)
class Made:
    """A stream: data; features: its numbers; error: the worse way, unit frame; base: what it is made on."""

    data: bytes
    features: int
    error: float
    base: FittedBase


def staged(target: Target, base: FittedBase, most: int, progress: Progress = no_progress) -> Stages:
    """Stages until they help no more, nobody sees more, or there are `most` bytes."""
    out = Stages(target, base)
    if not base.surface.levels:
        return out
    poor = 0
    for stage in range(STAGES):
        progress(stage / STAGES, "Fitting details")
        poor = poor + 1 if out.add() > BETTER else 0
        if poor == 2 or out.errors[-1] < LEAST_ERROR or len(out.payload()) + len(base.coded.positions) > most:
            break
    while out.values and out.errors[-1] == out.errors[-2]:
        del out.values[-1], out.errors[-1]
    return out


def checked(target: Target, faces: int, levels: int, bits: int, most: int,
            progress: Progress = no_progress) -> tuple[Stages, str]:
    """A base of about so many faces with stages, of which no finer level is farther off than a coarser one; and a message.

    Where a smooth scheme breaks that (large flat faces), new vertices are midpoints, which change nothing by themselves; where
    details do, the levels that are farther off are left out.
    """
    for schemes in (SCHEMES, SCHEMES[:1]):
        free = FreeBase(target, faces, levels, part(progress, 0, 0.3), schemes=schemes)
        stages = staged(target, free.rounded(bits), most, part(progress, 0.3, 1))
        finest = stages.settle()
        if finest == stages.base.surface.levels or not stages.base.surface.smooth:
            break
    if finest < stages.base.surface.levels:
        stages.leave_out(finest)
    return stages, free.message
