"""What is kept between runs in one folder: compiled code, and TetWild's results. How large it is, and away with it.

Only files of these two kinds, in these two folders, are counted and removed: the user may have chosen any folder.
"""
import os
from collections.abc import Iterator
from pathlib import Path

COMPILED, RESULTS = "compiled", "tetwild"
KINDS = {COMPILED: (".nbi", ".nbc"), RESULTS: (".npz",)}


def files(folder: Path) -> Iterator[os.DirEntry]:
    """The files that are kept in a cache folder; links are not followed."""
    for name, suffixes in KINDS.items():
        stack = [folder / name]
        while stack:
            try:
                with os.scandir(stack.pop()) as entries:
                    for entry in entries:
                        if entry.is_dir(follow_symlinks=False):
                            stack.append(entry.path)
                        elif entry.name.endswith(suffixes) and entry.is_file(follow_symlinks=False):
                            yield entry
            except OSError:  # not there, or not ours to read
                continue


def size(folder: Path) -> int:
    """Bytes of the files that are kept in a cache folder."""
    total = 0
    for entry in files(folder):
        try:
            total += entry.stat(follow_symlinks=False).st_size
        except OSError:  # removed meanwhile
            continue
    return total


def clear(folder: Path) -> tuple[int, int]:
    """Remove the files that are kept in a cache folder: (bytes removed, files that could not be)."""
    removed, refused = 0, 0
    for entry in list(files(folder)):
        try:
            count = entry.stat(follow_symlinks=False).st_size
            os.unlink(entry.path)
            removed += count
        except OSError:
            refused += 1
    return removed, refused
