"""The worker process, so that Blender's window stays alive: `python -m npm_blender.worker FOLDER`; see jobs.py.

In, either paths.json in FOLDER, with the names of .npmesh files to read; or `check` in FOLDER, to load every package and
report; or, on standard input, one number k a line for each mesh to compress, with mesh<k>.npz, that is, V (n, 3) and
F (m, 3), and mesh<k>.json, the fields of CompressSettings, in FOLDER. What it may use of the machine is in its
environment (worker_settings.py). Out, in FOLDER: 0.npmesh, 0.npz and 0.measured, 1.npmesh ..., streams, what was read from
them and how far they are from the mesh; and on standard output one JSON object a line: {"fraction", "message"} while it
runs, then {"report"} or {"error", "message"}, for each mesh or for all files together. Ends when its standard input
closes, that is, with the program that started it. Never loads bpy.
"""
import dataclasses
import json
import os
import queue
import shutil
import sys
import threading
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from .core.errors import MeshError, NpmError, StreamError
from .core.progress import part
from .core.settings import CompressSettings, LodSettings
from .dependencies import named_dependencies
from .packages import loaded
from .worker_settings import compute_settings

if TYPE_CHECKING:
    from .core.codec.stored_stream import StoredStream
    from .core.mesh.triangle_mesh import TriMesh

PATHS, CHECK = "paths.json", "check"
SECONDS_BETWEEN_REPORTS = 0.05
NICENESS = 3  # the window goes first where cores are few, and other programs do not halt a job; Windows: see jobs.py
MEASURING = 0.1  # share of the progress bar for measuring the errors of what was compressed


def write_mesh(folder: Path, k: int, mesh: "TriMesh", settings: CompressSettings) -> None:
    """Put the k-th mesh that is to be compressed into `folder`."""
    import numpy as np

    np.savez(folder / f"mesh{k}.npz", V=mesh.V, F=mesh.F)
    (folder / f"mesh{k}.json").write_text(json.dumps(dataclasses.asdict(settings)), encoding="utf-8")


def write_paths(folder: Path, paths: list[Path]) -> None:
    """Put the names of the files that are to be read into `folder`."""
    (folder / PATHS).write_text(json.dumps([str(path.absolute()) for path in paths]), encoding="utf-8")


def load_received(folder: Path, k: int) -> "StoredStream":
    """The k-th stream that the worker left in `folder`."""
    from .core.codec.stored_stream import StoredStream

    return StoredStream((folder / f"{k}.npmesh").read_bytes(), (folder / f"{k}.npz").read_bytes(),
                    (folder / f"{k}.measured").read_text(encoding="utf-8"))


def run(folder: Path, tasks: "queue.SimpleQueue[int]") -> int:
    """Do the job in `folder`; 0 if done, 1 if the input is at fault. Our bugs keep their traceback."""
    _say(fraction=0.0, message=_unless_first("Starting"))
    if (folder / PATHS).exists():
        return _answer(lambda: _read(folder))
    if (folder / CHECK).exists():
        return _answer(loaded)
    while True:  # the parent ends this process
        k = tasks.get()
        _answer(lambda: _compress(folder, k))  # noqa: B023 - called at once


def _answer(work: Callable[[], object]) -> int:
    """Say the report of `work`, or the error that it raises."""
    try:
        with named_dependencies():
            report = work()
    except NpmError as error:
        _say(**_described(error))
        return 1
    _say(report=report)
    return 0


def _compress(folder: Path, k: int) -> dict:
    import numpy as np

    from .core.codec.compression import compress
    from .core.codec.stored_stream import receive
    from .core.decimation import collapse_loop
    from .core.evaluation.prefix_errors import measure
    from .core.jit import is_cold
    from .core.mesh.triangle_mesh import TriMesh

    try:
        with np.load(folder / f"mesh{k}.npz", allow_pickle=False) as arrays:
            mesh = TriMesh.from_arrays(arrays["V"], arrays["F"])
        (folder / f"mesh{k}.npz").unlink()
        fields = json.loads((folder / f"mesh{k}.json").read_text(encoding="utf-8"))
        settings, notes = _possible(CompressSettings(**{**fields, "lod": LodSettings(**fields["lod"])}))
        compiled = is_cold(collapse_loop.run)
        reporter = _Reporter()
        compressed = compress(mesh, settings, part(reporter, 0.0, 1 - MEASURING), compute_settings())
        received = receive(compressed.data)
        measured = measure(received.open(), mesh, part(reporter, 1 - MEASURING, 1.0))
    except MemoryError:
        raise MeshError("Expected a mesh that fits into memory, found too little free; "
                        "close other programs, or decimate the mesh first") from None
    _store(folder, k, dataclasses.replace(received, measured=measured.to_text()))
    report = dataclasses.asdict(compressed.report)
    return {**report, "messages": [*report["messages"], *notes], "compiled": compiled}


def _possible(settings: CompressSettings) -> tuple[CompressSettings, list[str]]:
    """The settings without refinement where torch is missing, and what to say of that."""
    if not settings.refine_steps or find_spec("torch"):
        return settings, []
    return dataclasses.replace(settings, refine_steps=0), ["not refined, as PyTorch was not found"]


def _read(folder: Path) -> list[dict]:
    """Read every file, whatever the others are like; one entry each."""
    from .core.codec.stored_stream import receive
    from .core.files import read_file

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


def _store(folder: Path, k: int, received: "StoredStream") -> None:
    (folder / f"{k}.npmesh").write_bytes(received.data)
    (folder / f"{k}.npz").write_bytes(received.arrays)
    (folder / f"{k}.measured").write_text(received.measured, encoding="utf-8")


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


def _tasks_until_parent_ends(folder: Path) -> "queue.SimpleQueue[int]":
    """The numbers that arrive on standard input. When the parent goes, it closes; then remove the folder and end."""
    tasks: queue.SimpleQueue[int] = queue.SimpleQueue()

    def watch() -> None:
        rest = b""
        while said := os.read(0, 1024):  # not sys.stdin: its lock would be held when Python ends with a traceback
            *lines, rest = (rest + said).split(b"\n")
            for line in lines:
                tasks.put(int(line))
        shutil.rmtree(folder, ignore_errors=True)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    return tasks


if __name__ == "__main__":
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    status = run(Path(sys.argv[1]), _tasks_until_parent_ends(Path(sys.argv[1])))
    sys.stdout.flush()
    os._exit(status)  # not sys.exit: the watching thread still blocks on standard input
