"""One switch for compiled loops: numba where it is installed, the same functions in plain Python where it is not.

Every function marked `njit` works on 64-bit integer arrays and Python integers only, so both ways give the same bits.
"""
from collections.abc import Callable

try:
    import numba
except ImportError:
    numba = None

COMPILED = numba is not None and not numba.config.DISABLE_JIT


def njit(function: Callable) -> Callable:
    """`function` compiled by numba with an on-disk cache, or `function` itself where numba is missing.

    The cache belongs to the name under which the package was imported (`npm_blender` in a worker process,
    `bl_ext.<repository>.npm_blender` inside Blender): numba would share one cache between both, and its entries
    import their module by name.
    """
    if numba is None:
        return function
    function.__qualname__ = f"{function.__module__.replace('.', '_')}.{function.__qualname__}"
    return numba.njit(cache=True)(function)
