"""Integers of a displaced surface on a base, stage after stage, each kept only if it helps; and the stream that they make."""
from dataclasses import dataclass, replace

import numpy as np

from ..bitstream import STEP_UNIT, DisplacedCoding, Header, Rung, around, encode_displacements, write_ladder
from ..fitting import DetailFit, StageFit, default_rate
from ..geometry import ClosestPoints
from ..mesh import TriMesh
from .fitted_base import LEAST_ERROR, FittedBase
from .target import CHECKED, Target

GROWTH = 22                     # steps from level to level, over GROWTH_UNIT
SAME, NOT_WORSE = 1.01, 1.04    # errors of one level, and of two, that differ by less are the same: samples
FIRST_STEP = 2.0                # step of level 0 in the first stage, over the error of the base
HELPFUL = 0.85                  # a stage that leaves less of the error is taken as it is
TWICE = 2                       # stages of two passes, those after have one


@dataclass(frozen=True)
class Made:
    """A stream: data; features: its numbers; error: the worse way, unit frame; base: what it is made on."""

    data: bytes
    features: int
    error: float
    base: FittedBase


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
        self.level_errors = np.zeros((0, 0))  # of each number of stages and level, see `settle`
        self._measured: list[np.ndarray] = []  # errors of all levels but the finest, after each number of stages
        self._last: StageFit | None = None

    def coding(self, step: int, stages: int, payload: int) -> DisplacedCoding:
        """Of a stream whose first stage has `step`."""
        ends = self.ends or (stages,) * self.base.surface.levels
        return DisplacedCoding(self.base.surface.smooth, step, GROWTH, stages, payload, ends)

    def error(self, value: np.ndarray, steps: np.ndarray) -> float:
        """How far integers (n,) with steps (levels + 1,) leave the finest level from the source."""
        return self.fit.error(self.base.V0, value * np.repeat(steps, np.diff(self.base.surface.first)), CHECKED)

    def add(self) -> float:
        """One stage more: what is left of the error. A stage that does not help stays empty, and so does its finest level."""
        surface, stage = self.base.surface, len(self.values)
        steps = self.coding(self.step, 1, 0).steps(surface.levels, stage)
        before = self._last or (StageFit(self.values[-1], default_rate(surface.levels), np.inf) if self.values else None)
        found = self.fit.stage(self.base.V0, steps, before, surface.levels,
                               passes=2 if stage < TWICE else 1)
        kept = 2 * self.values[-1] if self.values else np.zeros_like(found.value)
        error = self.error(found.value, steps)
        if error > HELPFUL * self.errors[-1]:
            found, error = self._without_finest(found, error, kept, steps)
        if error > self.errors[-1]:
            found, error = found._replace(value=kept), self.errors[-1]
        self._last = found
        self.values.append(found.value)
        self.errors.append(error)
        return error / max(self.errors[-2], 1e-12)

    def _without_finest(self, found: StageFit, error: float, kept: np.ndarray, steps: np.ndarray) -> tuple[StageFit, float]:
        """A stage and its error; without the changes of the finest level that has some, where these do not help."""
        changed, first = np.flatnonzero(found.value != kept), self.base.surface.first
        start = int(first[np.searchsorted(first, changed[-1], side="right") - 1]) if len(changed) else 0
        if not start:
            return found, error
        fewer = found.value.copy()
        fewer[start:] = kept[start:]
        left = self.error(fewer, steps)
        return (found._replace(value=fewer), left) if left <= error else (found, error)

    def settle(self) -> int:
        """Decide after which stage each level but the finest stays as it is, so that more numbers are never farther off; and
        return the finest level up to which none is farther off than the one below."""
        surface, first = self.base.surface, self.base.surface.first
        trees: dict[int, ClosestPoints] = {}
        for k in range(len(self._measured), len(self.values) + 1):
            moves = np.zeros(int(first[-1]))
            if k:
                steps = self.coding(self.step, 1, 0).steps(surface.levels, k - 1)
                moves += self.values[k - 1] * np.repeat(steps, np.diff(first))
            X, row = surface.build(self.base.V0, moves).X, np.zeros(surface.levels)
            for level in range(surface.levels):
                shown, F = surface.shown_of(X, level), surface.hierarchy[level].F
                trees[level] = trees[level].moved(shown, F) if level in trees else ClosestPoints(TriMesh(shown, F))
                row[level] = self.target.source.error(TriMesh(shown, F), CHECKED // 2, trees[level])
            self._measured.append(row)
        errors = np.column_stack([np.array(self._measured), self.errors])
        self.level_errors = errors
        self.ends = tuple(_falling(errors[:, level]) for level in range(surface.levels))
        for level, end in enumerate(self.ends):
            errors[end:, level] = errors[end, level]
        if not surface.smooth:  # without numbers, all levels are the same surface
            errors[0] = errors[0, 0]
        fine = (errors[:, 1:] <= NOT_WORSE * errors[:, :-1]).all(0)
        return surface.levels if fine.all() else int(np.argmin(fine))

    def leave_out(self, finest: int) -> None:
        """Levels above `finest`, with their numbers."""
        base = self.base
        n = int(base.surface.first[finest + 1])
        self.base, self.near = replace(base, surface=base.surface.with_levels(finest)), self.near[:n]
        self.fit = DetailFit(self.target.source, self.base.surface, self.near)
        self.values, self.ends, self._last, self._measured = [value[:n] for value in self.values], (), None, []
        steps = self.coding(self.step, 1, 0)
        self.errors = [self.error(np.zeros(n, np.int64), steps.steps(finest, 0))]
        self.errors += [self.error(value, steps.steps(finest, k)) for k, value in enumerate(self.values)]

    def keep(self, count: int) -> None:
        """Only the first stages."""
        del self.values[count:], self.errors[count + 1:], self._measured[count + 1:]
        self.ends = ()
        if self._last:
            self._last = self._last._replace(value=self.values[-1]) if self.values else None

    @property
    def base_size(self) -> int:
        """Bytes of the rung without numbers."""
        return len(self.stream(self.nothing(), self.step)[0])

    def sizes(self) -> np.ndarray:
        """Bytes of the rung after each stage (stages + 1,), from those of its base on."""
        if not self.values:
            return np.array([self.base_size])
        _, coded = encode_displacements(self.table, self.near, self.base.surface.first)
        numbers = np.cumsum(coded.coded @ np.diff(self.base.surface.first))
        payload = coded.ends[np.minimum(-(-numbers // coded.group), len(coded.ends) - 1)]
        return self.base_size + np.concatenate([[0], payload])

    def stream(self, table: np.ndarray, step: int) -> tuple[bytes, int]:
        """The stream of table (stages, n) whose first stage has `step`, and how many numbers it has."""
        rung = self.rung(table, step)
        return write_ladder([rung]), rung.header.total_features

    def rung(self, table: np.ndarray, step: int) -> Rung:
        """The rung of table (stages, n) whose first stage has `step`."""
        surface, facts = self.base.surface, self.target.facts
        data, coded = encode_displacements(table, self.near, surface.first)
        x, y, z = map(float, facts.frame.centre)
        header = Header(surface.levels, self.base.bits, coded.numbers, facts.faces, facts.vertices, (x, y, z), facts.frame.size,
                        self.coding(step, len(table), len(data)))
        return Rung(header, self.base.coded, data)

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
