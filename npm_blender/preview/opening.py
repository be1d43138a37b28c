"""Opening a stream in this process, with errors that say what to do about a package that is missing."""
import os
from typing import TYPE_CHECKING

from ..preferences import cache_folder
from ..runtime.caches import COMPILED
from ..runtime.dependencies import compiled_code_in, named_dependencies

if TYPE_CHECKING:
    from ..core.codec import ProgressiveMesh, StoredStream


def receive(data: bytes) -> "StoredStream":
    """What is read from the bytes of a stream. Raises StreamError or DependencyError.

    The window stands still while numba is loaded, half a second, or compiles, ten; where there is one, jobs.ReadJob
    does this in another process.
    """
    folder = cache_folder()
    with named_dependencies(), compiled_code_in(folder and os.path.join(folder, COMPILED)):
        from ..core.codec import receive

        return receive(data)


def open_received(received: "StoredStream") -> "ProgressiveMesh":
    """`StoredStream.open`. Raises StreamError, WeightsError or DependencyError."""
    with named_dependencies():
        return received.open()
