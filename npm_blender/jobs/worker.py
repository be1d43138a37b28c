"""The worker process: `python -m npm_blender.jobs.worker FOLDER`. What it is told and what it answers: protocol.py.

Never loads bpy. Ends when its standard input closes, that is, with the program that started it.
"""
import dataclasses
import os
import queue
import shutil
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

from ..core.errors import MeshError, NpmError, StreamError
from ..core.progress import part
from ..runtime.dependencies import named_dependencies
from ..runtime.packages import loaded
from . import protocol

SECONDS_BETWEEN_REPORTS = 0.05
NICENESS = 3  # the window goes first where cores are few, and other programs do not halt a job; Windows: see process.py
MEASURING = 0.1  # share of the progress bar for measuring the errors of what was compressed


def run(folder: Path, tasks: "queue.SimpleQueue[int]") -> int:
    """Do the job in `folder`; 0 if done, 1 if the input is at fault. Our bugs keep their traceback."""
    _say(fraction=0.0, message=_unless_first("Starting"))
    paths = protocol.read_paths(folder)
    if paths is not None:
        return _answer(lambda: _read(folder, paths))
    if protocol.is_check(folder):
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
        _say(**protocol.described(error))
        return 1
    _say(report=report)
    return 0


def _compress(folder: Path, k: int) -> dict:
    from ..core.codec import compress, receive
    from ..core.decimation import needs_compiling
    from ..core.evaluation import measure_prefixes

    try:
        mesh, settings = protocol.take_mesh(folder, k)
        compiled = needs_compiling()
        reporter = _Reporter()
        compressed = compress(mesh, settings, part(reporter, 0.0, 1 - MEASURING))
        received = receive(compressed.data)
        measured = measure_prefixes(received.open(), mesh, part(reporter, 1 - MEASURING, 1.0))
    except MemoryError:
        raise MeshError("Expected a mesh that fits into memory, found too little free; "
                        "close other programs, or decimate the mesh first") from None
    protocol.write_received(folder, k, dataclasses.replace(received, measured=measured.to_text()))
    return {**dataclasses.asdict(compressed.report), "compiled": compiled}


def _read(folder: Path, paths: list[Path]) -> list[dict]:
    """Read every file, whatever the others are like; one entry each."""
    from ..core.codec import receive
    from ..core.files import read_file

    outcomes: list[dict] = []
    for k, path in enumerate(paths):
        _say(fraction=k / len(paths), message=_unless_first(f"Reading {path.name}"))
        try:
            received = receive(read_file(path))
            protocol.write_received(folder, k, received)
            outcomes.append({"bytes": len(received.data)})
        except MemoryError:
            outcomes.append(protocol.described(StreamError(
                "Expected a stream that fits into memory, found too little free; check that this is an .npmesh file")))
        except NpmError as error:
            outcomes.append(protocol.described(error))
    return outcomes


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
    sys.stdout.write(protocol.line_of(**fields))
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
