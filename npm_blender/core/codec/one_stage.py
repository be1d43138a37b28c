"""A displaced surface that is made for a size: one stage, whose step fills the bytes."""
import numpy as np

from ..bitstream import STEP_UNIT
from ..fitting import StageFit, default_rate
from ..progress import Progress, no_progress
from .stages import Made, Stages

AIM, FULL, TRIES = 0.988, 0.972, 4  # of a budget: what is aimed at, what is full, how often it is tried
STAGES = 14                     # steps that are tried, each half as large as the one before
BETTER, LARGER = 0.98, 1.2      # more bytes that leave more than this of the error end the search


class OneStage:
    """Streams of one stage over the base of `stages`, which has none yet."""

    def __init__(self, stages: Stages) -> None:
        self.stages = stages

    def filled(self, budget: int, progress: Progress = no_progress) -> Made:
        """The stream of one stage whose step fills a budget."""
        base = self.stages.base
        best = last = Made(*self.stages.stream(self.stages.nothing(), self.stages.step), base.error, base)
        before = StageFit(np.zeros(len(self.stages.near), np.int64), default_rate(base.surface.levels), np.inf)
        for stage in range(STAGES):
            progress(stage / STAGES, "Fitting details")
            found, now = self._one_stage(self.stages.step + stage * STEP_UNIT, before, 2)
            if len(now.data) > budget:
                return self._between(best, last, now, self.stages.step + (stage - 1) * STEP_UNIT, before, budget)
            if now.error > BETTER * last.error and len(now.data) > LARGER * len(last.data):
                break
            before, last = found, now
            best = min(best, now, key=lambda one: one.error)
        return best

    def _one_stage(self, step: int, before: StageFit, scale: float) -> tuple[StageFit, Made]:
        """A stream of one stage, from the integers of another whose steps were `scale` times as large."""
        start = before._replace(value=np.rint(before.value * scale).astype(np.int64))
        stages, base = self.stages, self.stages.base
        steps = stages.coding(step, 1, 0).steps(base.surface.levels, 0)
        found = stages.fit.improved(base.V0, steps, start, np.zeros_like(start.value), base.surface.levels)
        return found, Made(*stages.stream(found.value[None], step), stages.error(found.value, steps), base)

    def _between(self, best: Made, last: Made, over: Made, step: int, before: StageFit, budget: int) -> Made:
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
