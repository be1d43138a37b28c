"""Round calls of the core: missing packages become one-line errors with a remedy, compiled code goes where it may."""
from collections.abc import Iterator
from contextlib import contextmanager

from ..core.errors import DependencyError
from .packages import remedy


@contextmanager
def named_dependencies() -> Iterator[None]:
    """Raise DependencyError for an ImportError of another package; our own broken imports stay tracebacks."""
    try:
        yield
    except ImportError as error:
        name = (error.name or "").partition(".")[0]
        if name == __package__.partition(".")[0]:
            raise
        found = "found none" if isinstance(error, ModuleNotFoundError) else f"found one that does not load ({error})"
        raise DependencyError(f"Expected the Python package {name or 'that this step needs'}, {found}; "
                              f"{remedy(name)}") from error


@contextmanager
def compiled_code_in(folder: str | None) -> Iterator[None]:
    """Let modules that are imported meanwhile keep their compiled code in `folder`; other users of numba keep theirs.

    numba asks where when a function is decorated. The worker process has NUMBA_CACHE_DIR instead.
    """
    try:
        import numba
    except ImportError:
        numba = None  # opening a file does without
    if folder is None or numba is None:
        yield
        return
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = folder
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before
