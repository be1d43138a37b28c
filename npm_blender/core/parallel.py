"""Independent pieces of one step on several threads. Compiled loops (see `jit.compiled`) run beside each other.

What the pieces are never depends on the number of threads, so neither does the result.
"""
import os
from collections import deque
from collections.abc import Callable, Iterable
from itertools import islice
from threading import Thread
from typing import Any, TypeVar

from .progress import Progress, no_progress

T = TypeVar("T")
R = TypeVar("R")
MOST = 8  # threads: beyond that the memory is busy
_known: set[object] = set()  # code that has run in this process


def threads() -> int:
    """Threads to use: OMP_NUM_THREADS where it is a number above 0, else one a core; at most MOST.

    >>> from npm_blender.core.parallel import MOST, threads
    >>> 1 <= threads() <= MOST
    True
    """
    asked = os.environ.get("OMP_NUM_THREADS", "")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(int(asked) if asked.isdecimal() and int(asked) else cores, MOST)


def first_time(function: Callable) -> bool:
    """Whether this is called with a function's code for the first time in this process.

    Such code should run once before it runs on several threads: numba notes the types that it is called with, and some
    builds of it (Debian's) end the process when two threads show it the same new type at the same time.

    >>> from npm_blender.core.parallel import first_time
    >>> def area(radius):
    ...     return 3 * radius**2
    >>> first_time(area), first_time(area)
    (True, False)
    """
    code = getattr(function, "__code__", function)
    new = code not in _known
    _known.add(code)
    return new


def each(task: Callable[[T], R], pieces: Iterable[T], progress: Progress = no_progress, message: str = "") -> list[R]:
    """task(piece) of all pieces, in their order. The calling thread does its share, and calls `progress` in between.

    The first piece of a new task (see `first_time`) runs alone. Raises what the first failing piece or `progress` does, when
    no other is running any more.

    >>> from npm_blender.core.parallel import each
    >>> each(abs, [-3, 1, -2])
    [3, 1, 2]
    """
    pieces = list(pieces)
    results: dict[int, R] = {}
    failures: dict[int, BaseException] = {}
    todo = iter(range(len(pieces)))  # each number is taken once

    def work(progress: Progress, most: int | None = None) -> None:
        for k in islice(todo, most):
            try:
                progress(len(results) / len(pieces), message)
                results[k] = task(pieces[k])
            except BaseException as error:  # raised below, in the calling thread
                failures[k] = error
                deque(todo, 0)  # no other piece begins

    helpers = [Thread(target=work, args=(no_progress,)) for _ in range(min(threads(), len(pieces)) - 1)]
    try:
        if first_time(task):
            work(progress, 1)
        for helper in helpers:
            helper.start()
        work(progress)
    finally:
        deque(todo, 0)
        for helper in helpers:
            if helper.ident is not None:  # it did start
                helper.join()
    if failures:
        raise failures[min(failures)]
    return [results[k] for k in range(len(pieces))]


def together(*steps: Callable[[], Any]) -> list[Any]:
    """What the steps return, in their order; they run beside each other, as far as there are threads.

    >>> from npm_blender.core.parallel import together
    >>> together(lambda: "border", lambda: 12)
    ['border', 12]
    """
    return each(lambda step: step(), steps)
