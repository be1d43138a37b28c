"""Turns a missing or broken package into a one-line error with its remedy, at the two doors to the codec."""
from collections.abc import Iterator
from contextlib import contextmanager

from .core.errors import DependencyError


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
                              "reinstall the extension, then restart Blender") from error


def open_stream(data: bytes):
    """`core.codec.open_stream`, imported at first use. Raises StreamError, WeightsError or DependencyError."""
    with named_dependencies():
        from .core import codec

        return codec.open_stream(data)
