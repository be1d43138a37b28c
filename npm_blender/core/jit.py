"""Compiled loops. The one module that knows numba.

`njit` is for what a receiver needs: compiled where numba is installed, the same functions in plain Python where it is
not. They work on 64-bit integer arrays and Python integers only, so both ways give the same bits.
`compiled` is for what only a sender needs, where plain Python would take hours: importing it needs numba.
"""
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, overload

try:
    import numba
except ImportError:
    numba = None

F = TypeVar("F", bound=Callable)  # a compiled function is called as the function that it was made from

COMPILED = numba is not None and not numba.config.DISABLE_JIT


def _cached(function: Callable, **options: object) -> Any:
    """`function` compiled with an on-disk cache of its own.

    The cache belongs to the name under which the package was imported (`npm_blender` in a worker process,
    `bl_ext.<repository>.npm_blender` inside Blender): numba would share one cache between both, and its entries
    import their module by name.
    """
    function.__qualname__ = f"{function.__module__.replace('.', '_')}.{function.__qualname__}"
    return numba.njit(cache=True, **options)(function)


@overload
def njit(function: F, *, inline: str = ...) -> F: ...
@overload
def njit(function: None = None, *, inline: str = ...) -> Callable[[F], F]: ...
def njit(function: Callable | None = None, *, inline: str = "never") -> Any:
    """`function` compiled by numba, or `function` itself where numba is missing.

    It makes no array and returns none: as with `compiled`, references are not counted, which takes a third off the time of
    the entropy coder. inline: "always" makes the function a part of its callers: a call hands over every field of every tuple.
    """
    if function is None:
        return lambda found: njit(found, inline=inline)
    return function if numba is None else _cached(function, _nrt=False, inline=inline)


@overload
def compiled(function: F, *, inline: str = ..., allocates: bool = ...) -> F: ...
@overload
def compiled(function: None = None, *, inline: str = ..., allocates: bool = ...) -> Callable[[F], F]: ...
def compiled(function: Callable | None = None, *, inline: str = "never", allocates: bool = False) -> Any:
    """`function` compiled by numba, without the interpreter's lock. Raises ModuleNotFoundError where numba is missing.

    A division by zero gives infinity or NaN, as in NumPy. inline: "always" makes the function a part of its callers.
    allocates: whether it makes an array or returns one; all others are compiled without counting references to arrays
    (`_nrt`), which took half of the time of a decimation: numba counts with locked instructions, several for each call that
    gets a named tuple of arrays.
    """
    if numba is None:
        raise ModuleNotFoundError("No module named 'numba'", name="numba")
    if function is None:
        return lambda found: compiled(found, inline=inline, allocates=allocates)
    return _cached(function, nogil=True, inline=inline, error_model="numpy", _nrt=allocates)


def is_cold(function: Any) -> bool:
    """Whether the next call of a compiled function has to compile it: it was not called yet, and nothing is on disk."""
    if not COMPILED or function.signatures:
        return False
    name = f"{Path(function.py_func.__code__.co_filename).stem}.{function.py_func.__qualname__}-*.nbi"
    return not any(Path(function.stats.cache_path).glob(name))
