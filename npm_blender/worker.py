"""The worker process, so that Blender's window stays alive: `python -m npm_blender.worker FOLDER`; see jobs.py.

In, in FOLDER: mesh.npz with V (n, 3) and F (m, 3); settings.json with the fields of CompressSettings. Out:
stream.npmesh in FOLDER, and on standard output one JSON object a line: {"fraction", "message"} while it runs, then
{"report"} or {"error", "message"}. Ends when its standard input closes, that is, with the program that started it.
Never loads bpy.
"""
import dataclasses
import json
import os
import shutil
import sys
import threading
import time
from pathlib import Path

import numpy as np

from .core.errors import NpmError
from .core.mesh import TriMesh
from .core.settings import CompressSettings, LodSettings
from .dependencies import named_dependencies

MESH, SETTINGS, STREAM = "mesh.npz", "settings.json", "stream.npmesh"
SECONDS_BETWEEN_REPORTS = 0.05


def write_job(folder: Path, mesh: TriMesh, settings: CompressSettings) -> None:
    """Put what `run` reads into `folder`."""
    with open(folder / MESH, "wb") as file:
        np.savez(file, V=mesh.V, F=mesh.F)
    (folder / SETTINGS).write_text(json.dumps(dataclasses.asdict(settings)), encoding="utf-8")


def read_job(folder: Path) -> tuple[TriMesh, CompressSettings]:
    """What `write_job` put into `folder`."""
    with np.load(folder / MESH, allow_pickle=False) as arrays:
        mesh = TriMesh.from_arrays(arrays["V"], arrays["F"])
    fields = json.loads((folder / SETTINGS).read_text(encoding="utf-8"))
    return mesh, CompressSettings(**{**fields, "lod": LodSettings(**fields["lod"])})


def run(folder: Path) -> int:
    """Compress the job in `folder`; 0 if done, 1 if the input is at fault. Our bugs keep their traceback."""
    try:
        mesh, settings = read_job(folder)
        with named_dependencies():
            from .core.codec import compress

            compressed = compress(mesh, settings, _Reporter())
        (folder / STREAM).write_bytes(compressed.data)
    except NpmError as error:
        _say(error=type(error).__name__, message=str(error))
        return 1
    except MemoryError:
        _say(error="MeshError", message="Expected a mesh that fits into memory, found too little free; "
                                        "close other programs, or decimate the mesh first")
        return 1
    _say(report=dataclasses.asdict(compressed.report))
    return 0


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
