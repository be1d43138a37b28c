"""The worker process, so that Blender's window stays alive: `python -m npm_blender.worker FOLDER`; see jobs.py.

In, in FOLDER: either mesh.npz with V (n, 3) and F (m, 3) and settings.json with the fields of CompressSettings, or
paths.json with the names of .npmesh files. Out, in FOLDER: 0.npmesh and 0.npz, 1.npmesh ..., streams and what was read
from them; and on standard output one JSON object a line: {"fraction", "message"} while it runs, then {"report"} or
{"error", "message"}. Ends when its standard input closes, that is, with the program that started it. Never loads bpy.
"""
import dataclasses
import json
import os
import shutil
import sys
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING

from .core.errors import MeshError, NpmError, StreamError
from .core.settings import CompressSettings, LodSettings
from .dependencies import named_dependencies

if TYPE_CHECKING:
    from .core.mesh import TriMesh
    from .core.received import Received

MESH, SETTINGS, PATHS = "mesh.npz", "settings.json", "paths.json"
SECONDS_BETWEEN_REPORTS = 0.05


def write_mesh(folder: Path, mesh: "TriMesh", settings: CompressSettings) -> None:
    """Put what is to be compressed into `folder`."""
    import numpy as np

    with open(folder / MESH, "wb") as file:
        np.savez(file, V=mesh.V, F=mesh.F)
    (folder / SETTINGS).write_text(json.dumps(dataclasses.asdict(settings)), encoding="utf-8")


def write_paths(folder: Path, paths: list[Path]) -> None:
    """Put the names of the files that are to be read into `folder`."""
    (folder / PATHS).write_text(json.dumps([str(path.absolute()) for path in paths]), encoding="utf-8")


def load_received(folder: Path, k: int) -> "Received":
    """The k-th stream that the worker left in `folder`."""
    from .core.received import Received

    return Received((folder / f"{k}.npmesh").read_bytes(), (folder / f"{k}.npz").read_bytes())


def run(folder: Path) -> int:
    """Do the job in `folder`; 0 if done, 1 if the input is at fault. Our bugs keep their traceback."""
    _say(fraction=0.0, message=_unless_first("Starting"))
    try:
        with named_dependencies():
            report = _read(folder) if (folder / PATHS).exists() else _compress(folder)
    except NpmError as error:
        _say(**_described(error))
        return 1
    _say(report=report)
    return 0


def _compress(folder: Path) -> dict:
    import numpy as np

    from .core.codec import compress
    from .core.mesh import TriMesh
    from .core.received import receive

    try:
        with np.load(folder / MESH, allow_pickle=False) as arrays:
            mesh = TriMesh.from_arrays(arrays["V"], arrays["F"])
        fields = json.loads((folder / SETTINGS).read_text(encoding="utf-8"))
        settings = CompressSettings(**{**fields, "lod": LodSettings(**fields["lod"])})
        compressed = compress(mesh, settings, _Reporter())
    except MemoryError:
        raise MeshError("Expected a mesh that fits into memory, found too little free; "
                        "close other programs, or decimate the mesh first") from None
    _store(folder, 0, receive(compressed.data))
    return dataclasses.asdict(compressed.report)


def _read(folder: Path) -> list[dict]:
    """Read every file, whatever the others are like; one entry each."""
    from .core.files import read_file
    from .core.received import receive

    paths = [Path(path) for path in json.loads((folder / PATHS).read_text(encoding="utf-8"))]
    outcomes: list[dict] = []
    for k, path in enumerate(paths):
        _say(fraction=k / len(paths), message=_unless_first(f"Reading {path.name}"))
        try:
            received = receive(read_file(path))
            _store(folder, k, received)
            outcomes.append({"bytes": len(received.data)})
        except MemoryError:
            outcomes.append(_described(StreamError("Expected a stream that fits into memory, found too little free; "
                                                   "check that this is an .npmesh file")))
        except NpmError as error:
            outcomes.append(_described(error))
    return outcomes


def _store(folder: Path, k: int, received: "Received") -> None:
    (folder / f"{k}.npmesh").write_bytes(received.data)
    (folder / f"{k}.npz").write_bytes(received.arrays)


def _described(error: NpmError) -> dict:
    return {"error": type(error).__name__, "message": str(error)}


def _unless_first(message: str) -> str:
    """`message`, or, if nothing is compiled yet, the reason why the user will wait."""
    cache = os.environ.get("NUMBA_CACHE_DIR")
    compiled = not cache or any(Path(cache).rglob("*.nbi"))
    return message if compiled else "Compiling code, this first time only"


class _Reporter:
    """A Progress that writes JSON lines, not more often than anyone looks."""

    def __init__(self) -> None:
        self._last = ("", 0.0)

    def __call__(self, fraction: float, message: str) -> None:
        said, when = self._last
        now = time.monotonic()
        if message != said or now - when >= SECONDS_BETWEEN_REPORTS:
            self._last = (message, now)
            _say(fraction=float(fraction), message=message)


def _say(**fields: object) -> None:
    sys.stdout.write(json.dumps(fields) + "\n")
    sys.stdout.flush()


def _end_with_parent(folder: Path) -> None:
    """Watch standard input: when the parent goes, it closes; then remove the folder and end."""
    def watch() -> None:
        while os.read(0, 1024):  # not sys.stdin: its lock would be held when Python ends with a traceback
            pass
        shutil.rmtree(folder, ignore_errors=True)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


if __name__ == "__main__":
    _end_with_parent(Path(sys.argv[1]))
    status = run(Path(sys.argv[1]))
    sys.stdout.flush()
    os._exit(status)  # not sys.exit: the watching thread still blocks on standard input
