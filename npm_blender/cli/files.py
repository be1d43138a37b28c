"""Paths that the command line is given, checked before any work starts."""

import os
from pathlib import Path

from ..core.errors import FileError
from ..core.files import read_file

MESH_SUFFIXES = (".ply", ".obj", ".off", ".stl", ".glb")  # what core.meshio writes, whose table would load NumPy for --help


def check_input(path: Path) -> Path:
    """The path of an existing, readable file. Raises FileError if it is missing or a folder."""
    if path.is_dir():
        raise FileError(f"Expected a file to read, found the folder {path}; name a file in it")
    if not path.exists():
        raise FileError(f"Expected a file to read, found nothing at {path}; check the path")
    return path


def check_output(path: Path, source: Path, suffixes: tuple[str, ...]) -> Path:
    """The path of a file that may be written.

    Raises FileError if its suffix is not one of `suffixes`, its folder is missing, it is a folder, or it is the file
    `source` itself under this or another name.
    """
    if path.suffix.lower() not in suffixes:
        found = path.suffix or "no suffix"
        raise FileError(
            f"Expected an output name that ends in {' or '.join(suffixes)}, found {found} ({path}); rename it"
        )
    if not path.parent.is_dir():
        raise FileError(f"Expected an existing folder for the output, found none at {path.parent}; create it first")
    if path.is_dir():
        raise FileError(f"Expected an output file, found the folder {path}; choose another name")
    if path.exists() and source.exists() and os.path.samefile(path, source):
        raise FileError(f"Expected an output other than the input, found {path} for both; choose another name")
    return path


def open_stream_file(path: Path):
    """The `ProgressiveMesh` in an .npmesh file. Raises FileError, StreamError or WeightsError."""
    data = read_file(path)
    from ..core.codec import open_stream  # after the cheap check: this import loads much

    return open_stream(data)
