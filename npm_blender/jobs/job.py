"""A job in a worker process: start, look how far it is, take the result, cancel. Knows processes, not Blender.

Progress and errors come through files in the job's folder, not pipes: no threads, no deadlock, the same on every
system. The folder goes when the job ends, whichever way it ends.
"""
import atexit
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from ..core.progress import Progress, no_progress
from . import process, protocol
from .estimate import remaining
from .machine import WorkerSettings

POLL_SECONDS = 0.05

_running: list["Job"] = []


class WorkerCrash(RuntimeError):
    """The worker ended without a result or a message: a bug of ours, or the system ended it."""


class Job:
    """Work in a worker process; subclasses say which.

    fraction (0..1) and message tell how far it is, as of the last `poll`; doing and estimate, in seconds, are for
    whoever started it to set, and for whoever shows it.
    """

    doing = ""
    estimate: float | None = None

    def __init__(self, write: Callable[[Path], None], scratch: str | None, machine: WorkerSettings | None) -> None:
        """Start the worker. write: puts what it works on into the job's folder, which is made in `scratch`; machine:
        what the worker may use.

        Raises DependencyError if there is no Python to start.
        """
        self.fraction, self.message = 0.0, "Starting"
        self._last: dict = {}
        self._machine, self._created = machine or WorkerSettings(), time.perf_counter()
        self._folder = Path(tempfile.mkdtemp(prefix="npmesh_", dir=scratch))
        try:
            write(self._folder)
            self._start()
        except BaseException:
            shutil.rmtree(self._folder, ignore_errors=True)
            raise
        _running.append(self)

    def _start(self) -> None:
        self._process = process.start(self._folder, self._machine)
        self._output = open(self._folder / "out", encoding="utf-8")
        self._line = ""

    def poll(self) -> bool:
        """Read what the worker said since the last call; True once it has ended (then call `result`)."""
        ended = self._process.poll() is not None
        self._line += self._output.read()
        *lines, self._line = self._line.split("\n")
        for line in lines:
            self._heard(protocol.fields_of(line))
        return ended

    def seconds_left(self) -> float | None:
        """The time that is left, if there was an estimate."""
        if self.estimate is None:
            return None
        return remaining(self.estimate, self.fraction, time.perf_counter() - self._created)

    def _heard(self, said: dict) -> None:
        """Take one line of the worker."""
        self._last = said
        if "fraction" in said:
            self.fraction, self.message = max(self.fraction, said["fraction"]), said["message"]

    def result(self):
        """What the job made, after `poll` said that it has ended; removes the job's folder.

        Raises the NpmError that the worker met, or WorkerCrash with its traceback.
        """
        try:
            if "report" in self._last:
                return self._collect(self._last["report"])
            if "error" in self._last:
                raise protocol.error_in(self._last)
            raise self._crash()
        finally:
            self._close()

    def _crash(self) -> WorkerCrash:
        trace = (self._folder / "err").read_text(encoding="utf-8", errors="replace").strip()
        return WorkerCrash(f"The worker process ended early (code {self._process.returncode}) in the step "
                           f"'{self.message}'\n{trace}".rstrip())

    def _collect(self, report):
        """The result, from the worker's report and the files in the job's folder."""
        raise NotImplementedError

    def cancel(self) -> None:
        """End the worker at once, with every process that it started, and remove its folder."""
        self._close()

    def wait(self, progress: Progress = no_progress):
        """Block until the job has ended, telling `progress`; what `progress` raises cancels the job."""
        try:
            while not self.poll():
                progress(self.fraction, self.message)
                time.sleep(POLL_SECONDS)
        except BaseException:
            self.cancel()
            raise
        return self.result()

    def _end(self) -> None:
        self._output.close()
        process.end(self._process)

    def _close(self) -> None:
        self._end()
        shutil.rmtree(self._folder, ignore_errors=True)
        if self in _running:
            _running.remove(self)


def running() -> tuple[Job, ...]:
    """Jobs that have neither given their result nor been cancelled, oldest first."""
    return tuple(_running)


@atexit.register
def cancel_all() -> None:
    """Cancel every running job: the extension is being disabled, or the program ends."""
    for job in running():
        job.cancel()
