"""Progress and cancelling, the same for every long step.

A `Progress` is any callable `progress(fraction, message)`: fraction in 0..1 of the running step, message a short
phrase ("Decimating"). It may raise `Cancelled`; steps call it often enough that a cancel takes effect in 0.5 s.
"""
from collections.abc import Callable

Progress = Callable[[float, str], None]


def no_progress(fraction: float, message: str) -> None:
    """Ignore progress.

    >>> from npm_blender.core.progress import no_progress
    >>> no_progress(0.5, "Decimating")
    """


def part(progress: Progress, start: float, stop: float) -> Progress:
    """The share [start, stop] of `progress`, for a sub-step: its fraction t becomes start + (stop - start) t.

    >>> from npm_blender.core.progress import part
    >>> part(print, 0.5, 1.0)(0.5, "Decimating")
    0.75 Decimating
    """
    return lambda fraction, message: progress(start + (stop - start) * fraction, message)


def noted(progress: Progress, note: str) -> Progress:
    """`progress` with a note behind every message.

    >>> from npm_blender.core.progress import noted
    >>> noted(print, "2 of 3")(0.5, "Decimating")
    0.5 Decimating (2 of 3)
    """
    return lambda fraction, message: progress(fraction, f"{message} ({note})")


def rising(progress: Progress) -> Progress:
    """`progress` that never falls back: steps that come again keep the farthest fraction.

    >>> from npm_blender.core.progress import rising
    >>> report = rising(print)
    >>> report(0.5, "Decimating")
    0.5 Decimating
    >>> report(0.2, "Decimating")
    0.5 Decimating
    """
    farthest = 0.0

    def report(fraction: float, message: str) -> None:
        nonlocal farthest
        farthest = max(farthest, fraction)
        progress(farthest, message)

    return report
