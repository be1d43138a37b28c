"""Whole files in and out: every failure is a FileError of one line, and a write happens completely or not at all."""
import os
from pathlib import Path

from .errors import FileError

SUFFIX = ".npmesh"  # of compressed files


def read_file(path: str | os.PathLike) -> bytes:
    """The bytes of the file at `path`. Raises FileError if it is missing, a folder, empty or not readable."""
    path = Path(path)
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise FileError(f"Expected a file at {path}, found none; check the path") from None
    except IsADirectoryError:
        raise FileError(f"Expected a file at {path}, found a folder; name a file in it") from None
    except OSError as error:
        if path.is_dir():  # Windows reports a folder as not permitted
            raise FileError(f"Expected a file at {path}, found a folder; name a file in it") from None
        raise FileError(f"Expected to read {path}, found: {error.strerror or error}; check its permissions") from None
    except ValueError as error:
        raise FileError(f"Expected a path, found {str(path)!r}: {error}") from None
    if not data:
        raise FileError(f"Expected {path} to hold data, found an empty file; export it again")
    return data


def write_file(path: str | os.PathLike, data: bytes) -> None:
    """Write `data` to `path` atomically: a temporary file in the same folder, then a rename.

    An existing file is replaced only by a complete one. Raises FileError if the folder is missing or not writable,
    `path` is a folder, or the disk is full.
    """
    path = Path(path)
    if path.is_dir():
        raise FileError(f"Expected a file name, found the folder {path}; name a file in it")
    temporary = path.with_name(f".{path.name[:100]}.{os.getpid()}.part")
    try:
        try:
            temporary.write_bytes(data)
            os.replace(temporary, path)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
    except FileNotFoundError:
        raise FileError(f"Expected the folder {path.parent} to exist, found none; create it first") from None
    except OSError as error:
        raise FileError(f"Expected to write {path}, found: {error.strerror or error}; "
                        "check the folder's permissions and space") from None
    except ValueError as error:
        raise FileError(f"Expected a path, found {str(path)!r}: {error}") from None
