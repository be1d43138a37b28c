"""Independent pieces of one step on several threads. Compiled loops (see `jit.compiled`) run beside each other.

What the pieces are never depends on the number of threads, so neither does the result.
"""
import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from .progress import Progress, no_progress

T, R = TypeVar("T"), TypeVar("R")
MOST = 8  # threads: beyond that the memory is busy


def threads() -> int:
    """Threads to use: OMP_NUM_THREADS where it is a number above 0, else one a core; at most MOST."""
    asked = os.environ.get("OMP_NUM_THREADS", "")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(int(asked) if asked.isdecimal() and int(asked) else cores, MOST)


def each(task: Callable[[T], R], pieces: Iterable[T], progress: Progress = no_progress, message: str = "") -> list[R]:
    """task(piece) of all pieces, in their order.

    Raises what the first failing piece or `progress` does, when no other is running any more.
    """
    pieces = list(pieces)
    with ThreadPoolExecutor(threads()) as pool:
        futures = [pool.submit(task, piece) for piece in pieces]
        out = []
        try:
            for future in futures:
                progress(len(out) / len(pieces), message)
                out.append(future.result())
        except BaseException:
            for future in futures:
                future.cancel()
            raise
    return out
