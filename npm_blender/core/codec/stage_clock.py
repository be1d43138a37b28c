"""Seconds by stage, and the stages' shares of the progress bar."""
import time
from collections.abc import Callable

from ..progress import Progress, part, rising


class StageClock:
    """Seconds by stage; the stages' shares of the progress bar."""

    def __init__(self, progress: Progress, shares: dict[str, float]) -> None:
        self.seconds: dict[str, float] = {}
        total, start, self._parts = sum(shares.values()), 0.0, {}
        progress = rising(progress)
        for name, share in shares.items():
            self._parts[name] = part(progress, start / total, (start + share) / total)
            start += share

    def run(self, name: str, step: Callable, *arguments):
        """step(*arguments, progress), timed under `name`."""
        begun = time.perf_counter()
        try:
            return step(*arguments, self._parts[name])
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - begun
