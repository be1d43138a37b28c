"""Results kept between runs in the user's cache folder: for steps that take minutes or come out differently each time.

A cache never fails: where its folder cannot be written, nothing is kept, and a damaged entry counts as none.
"""
import hashlib
import io
import os
import sys
import zipfile
from pathlib import Path

import numpy as np

from ..errors import FileError
from ..files import write_file
from ..settings import CACHE_VARIABLE

LIMIT = 256 << 20  # bytes of all entries together; the ones not used for longest go first


def user_cache() -> Path:
    """The folder for this package's results: CACHE_VARIABLE's, or one among the user's caches; it need not exist."""
    if chosen := os.environ.get(CACHE_VARIABLE):
        return Path(chosen)
    home = Path(os.path.expanduser("~"))
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local"
    elif sys.platform == "darwin":
        base = home / "Library" / "Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or home / ".cache"
    return Path(base, "npm_blender")


def digest(*parts: str | np.ndarray) -> str:
    """SHA-256, in hexadecimal, of texts and arrays with their shapes and types."""
    out = hashlib.sha256()
    for p in parts:
        data = p.encode() if isinstance(p, str) else np.ascontiguousarray(p).tobytes()
        kind = "text" if isinstance(p, str) else f"{p.dtype.str}{p.shape}"
        out.update(f"{kind} {len(data)}\n".encode())
        out.update(data)
    return out.hexdigest()


def load(folder: Path, key: str) -> dict[str, np.ndarray] | None:
    """The arrays kept under `key`, or None. Marks the entry as used now."""
    path = folder / f"{key}.npz"
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        os.utime(path)
    except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile):
        return None
    return arrays


def keep(folder: Path, key: str, **arrays: np.ndarray) -> bool:
    """Keep arrays under `key`, atomically, and drop the oldest entries beyond LIMIT; False if that is not possible."""
    data = io.BytesIO()
    np.savez(data, **arrays)
    if data.tell() > LIMIT:
        return False
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_file(folder / f"{key}.npz", data.getvalue())
        entries = [(p.stat().st_mtime_ns, p.stat().st_size, p) for p in folder.glob("*.npz")]
        total = sum(size for _, size, _ in entries)
        for _, size, path in sorted(entries):
            if total <= LIMIT:
                break
            if path.stem != key:
                path.unlink(missing_ok=True)
                total -= size
    except (OSError, FileError):
        return False
    return True
