"""The codec's doors: missing packages become one-line errors with a remedy, compiled code goes where it may."""
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from .caches import COMPILED
from .core.errors import DependencyError
from .packages import remedy

if TYPE_CHECKING:
    from .core.codec.progressive_mesh import ProgressiveMesh
    from .core.codec.stored_stream import StoredStream


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


def receive(data: bytes) -> "StoredStream":
    """`core.received.receive` in this process. Raises StreamError or DependencyError.

    The window stands still while numba is loaded, half a second, or compiles, ten; where there is one, jobs.ReadJob
    does this in another process.
    """
    folder = cache_folder()
    with named_dependencies(), compiled_code_in(folder and os.path.join(folder, COMPILED)):
        from .core.codec.stored_stream import receive

        return receive(data)


def open_received(received: "StoredStream") -> "ProgressiveMesh":
    """`Received.open`. Raises StreamError, WeightsError or DependencyError."""
    with named_dependencies():
        return received.open()


def cache_folder() -> str | None:
    """Where Blender's side keeps what it need not make again; see `preferences.cache_folder`."""
    from .preferences import cache_folder

    return cache_folder()


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
