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
    """`function` compiled by numba with an on-disk cache, or `function` itself where numba is missing."""
    return function if numba is None else numba.njit(cache=True)(function)
