"""Work on arrays in a thread, so that the window draws meanwhile; nothing of Blender may be touched there."""
from collections.abc import Callable, Generator
from typing import TypeVar

WAIT_SECONDS = 0.005  # of a step: short for a window, and no busy waiting where there is none
T = TypeVar("T")


def in_thread(work: Callable[[], T]) -> Generator[None, None, T]:
    """Steps until `work` has ended; its result is the generator's return value. Raises what `work` raises.

    NumPy leaves Python's lock to the window while it computes. Who drops the generator waits for the end of `work`.
    """
    from concurrent.futures import ThreadPoolExecutor, wait

    with ThreadPoolExecutor(1) as pool:
        future = pool.submit(work)
        while not future.done():
            wait([future], WAIT_SECONDS)
            yield
    return future.result()
