"""Seconds by stage, and the stages' shares of the progress bar."""
import time
from collections.abc import Iterator
from contextlib import contextmanager

from ..progress import Progress, part, rising


class StageClock:
    """Times stages by name, and gives each its share of one progress bar.

    >>> from npm_blender.core.codec.stage_clock import StageClock
    >>> clock = StageClock(lambda fraction, message: print(fraction, message), {"clean": 1, "encode": 3})
    >>> with clock.stage("encode") as progress:
    ...     progress(0.5, "Encoding")
    0.625 Encoding
    >>> list(clock.seconds)
    ['encode']
    """

    def __init__(self, progress: Progress, shares: dict[str, float]) -> None:
        """shares: what each stage takes of the bar, in their order, in any unit.

        seconds: of each stage that was entered, all its times together.
        """
        self.seconds: dict[str, float] = {}
        total, start, self._parts = sum(shares.values()), 0.0, {}
        progress = rising(progress)
        for name, share in shares.items():
            self._parts[name] = part(progress, start / total, (start + share) / total)
            start += share

    @contextmanager
    def stage(self, name: str) -> Iterator[Progress]:
        """`with clock.stage(name) as progress`: what is inside is timed under `name`, also if it raises."""
        begun = time.perf_counter()
        try:
            yield self._parts[name]
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - begun
