"""Jobs in worker processes: start, look how far it is, take the result, cancel. Knows processes, not Blender.

Progress and errors come through files in the job's folder, not pipes: no threads, no deadlock, the same on every
system. The folder goes when the job ends, whichever way it ends.
"""
import atexit
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from .core import errors
from .core.progress import Progress, no_progress
from .core.settings import CompressSettings
from .estimate import remaining
from .worker_settings import WorkerSettings

if TYPE_CHECKING:
    from .core.codec.stored_stream import StoredStream
    from .core.mesh.triangle_mesh import TriMesh

PACKAGE_FOLDER = Path(__file__).parent
POLL_SECONDS = 0.05

# The worker imports the package under the name that it has here, bl_ext.<repository>.npm_blender when installed: numba
# keeps module names in what it caches, so both processes can share a cache only under one name. Arguments: the name,
# the package's folder, the job's folder.
BOOTSTRAP = """
import os, runpy, sys, types
name, folder = sys.argv[1:3]
parents = name.split(".")[:-1]
for k in range(len(parents)):
    module = sys.modules[".".join(parents[:k + 1])] = types.ModuleType(".".join(parents[:k + 1]))
    module.__path__ = [os.path.dirname(folder)]
if not parents:
    sys.path.insert(0, os.path.dirname(folder))
sys.argv[:] = sys.argv[2:]
runpy.run_module(name + ".worker", run_name="__main__")
"""

_running: list["Job"] = []


class WorkerCrash(RuntimeError):
    """The worker ended without a result or a message: a bug of ours, or the system ended it."""


@dataclass(frozen=True)
class Compressed:
    """stream: the compressed mesh, read again; report: the fields of the core's CompressReport; seconds: all of it."""

    stream: "StoredStream"
    report: dict
    seconds: float


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
        with open(self._folder / "out", "wb") as out, open(self._folder / "err", "wb") as err:
            self._process = subprocess.Popen(
                _command(self._folder), cwd=self._folder, env=_environment(self._folder, self._machine),
                stdin=subprocess.PIPE, stdout=out, stderr=err, **_own_group())
        self._output = open(self._folder / "out", encoding="utf-8")
        self._line = ""

    def poll(self) -> bool:
        """Read what the worker said since the last call; True once it has ended (then call `result`)."""
        ended = self._process.poll() is not None
        self._line += self._output.read()
        *lines, self._line = self._line.split("\n")
        for line in lines:
            self._heard(json.loads(line))
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
                raise _error(self._last)
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

    def _received(self, k: int) -> "StoredStream":
        from .worker import load_received

        return load_received(self._folder, k)

    def _end(self) -> None:
        if self._process.poll() is None:
            if os.name == "posix":
                os.killpg(self._process.pid, signal.SIGKILL)
            else:
                self._process.kill()
            self._process.wait()
        self._output.close()
        self._process.stdin.close()

    def _close(self) -> None:
        self._end()
        shutil.rmtree(self._folder, ignore_errors=True)
        if self in _running:
            _running.remove(self)


class CompressJob(Job):
    """Compress meshes one after the other, in one process; one that fails does not stop the others.

    `add` or `refuse` each of them, in order. The result is a list with, for each mesh, a Compressed, or the NpmError or
    WorkerCrash that says why there is none.
    """

    def __init__(self, seconds: Sequence[float], scratch: str | None = None,
                 machine: WorkerSettings | None = None) -> None:
        """Start; see Job. seconds: what each of the meshes will take, estimated, which makes their shares of `fraction`."""
        super().__init__(lambda folder: None, scratch, machine)
        self._shares = [max(s, 1e-3) / sum(max(s, 1e-3) for s in seconds) for s in seconds]
        self._outcomes: list[Compressed | Exception | int | None] = [None] * len(self._shares)
        self._added = 0
        self._began = time.perf_counter()

    @property
    def position(self) -> int:
        """Index of the mesh that is being compressed; the number of meshes at the end."""
        return next((k for k, outcome in enumerate(self._outcomes) if outcome is None), len(self._outcomes))

    def add(self, mesh: "TriMesh", settings: CompressSettings) -> None:
        """The next mesh."""
        from .worker import write_mesh

        write_mesh(self._folder, self._added, mesh, settings)
        self._added += 1
        self._tell(self._added - 1)

    def refuse(self, error: errors.NpmError) -> None:
        """The next mesh cannot be compressed."""
        self._outcomes[self._added] = error
        self._added += 1

    def repeat(self, k: int) -> None:
        """The next mesh is the k-th once more."""
        self._outcomes[self._added] = k
        self._added += 1

    def poll(self) -> bool:
        """As Job; a worker that crashed is started again for the meshes that are left."""
        ended = super().poll()
        k = self.position
        if k == len(self._outcomes):
            return True
        if ended and k < self._added:
            self._outcomes[k] = self._crash()
            self._end()
            if self.position == len(self._outcomes):
                return True
            self._start()
            for waiting in range(k + 1, self._added):
                if self._outcomes[waiting] is None:
                    self._tell(waiting)
        return False

    def result(self) -> list[Compressed | Exception]:
        """One outcome for each mesh, after `poll` said that the job has ended; removes the job's folder."""
        self._close()
        return [self._outcomes[o] if isinstance(o, int) else o for o in self._outcomes]

    def _tell(self, k: int) -> None:
        try:
            self._process.stdin.write(f"{k}\n".encode())
            self._process.stdin.flush()
        except OSError:
            pass  # the worker has ended; `poll` starts another one

    def _heard(self, said: dict) -> None:
        k = self.position
        if k == len(self._outcomes):  # all have their outcome; what the worker says while it ends is of no use
            return
        if "fraction" in said:
            self.message = said["message"]
            done = sum(self._shares[:k]) + self._shares[k] * said["fraction"]
            self.fraction = max(self.fraction, min(done, 1.0))
            return
        if "error" in said:
            self._outcomes[k] = _error(said)
        else:
            now = time.perf_counter()
            self._outcomes[k] = Compressed(self._received(k), said["report"], now - self._began)
        self._began = time.perf_counter()


class ReadJob(Job):
    """Read .npmesh files; the result is a Received for each, or the NpmError that says why there is none."""

    def __init__(self, paths: list[Path], scratch: str | None = None,
                 machine: WorkerSettings | None = None) -> None:
        """Start; see Job."""
        from .worker import write_paths

        super().__init__(lambda folder: write_paths(folder, paths), scratch, machine)

    def _collect(self, report: list[dict]) -> "list[StoredStream | errors.NpmError]":
        return [_error(said) if "error" in said else self._received(k) for k, said in enumerate(report)]


class CheckJob(Job):
    """Load every package that the worker uses; the result is `packages.loaded()` of that process."""

    def __init__(self, scratch: str | None = None, machine: WorkerSettings | None = None) -> None:
        """Start; see Job."""
        from .worker import CHECK

        super().__init__(lambda folder: (folder / CHECK).touch(), scratch, machine)

    def _collect(self, report: list[dict]) -> list[dict]:
        return report


def running() -> tuple[Job, ...]:
    """Jobs that have neither given their result nor been cancelled, oldest first."""
    return tuple(_running)


@atexit.register
def cancel_all() -> None:
    """Cancel every running job: the extension is being disabled, or the program ends."""
    for job in running():
        job.cancel()


def _error(said: dict) -> errors.NpmError:
    return getattr(errors, said["error"])(said["message"])


def _command(folder: Path) -> list[str]:
    """The command that runs the worker: this Python, this package."""
    if not sys.executable or not os.path.exists(sys.executable):
        raise errors.DependencyError(f"Expected Blender's Python program, found {sys.executable or 'none'}; "
                                     "reinstall Blender, or start it from its own folder")
    # -P: the current folder is no source of modules
    return [sys.executable, "-P", "-c", BOOTSTRAP, __package__, str(PACKAGE_FOLDER), str(folder)]


def _environment(folder: Path, machine: WorkerSettings) -> dict[str, str]:
    """The worker's environment: the packages that this process sees, and temporary files in the job's folder."""
    packages = [p for p in sys.path if os.path.basename(p) in ("site-packages", "dist-packages")]
    env = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON") or k == "PYTHONDONTWRITEBYTECODE"}
    env["PYTHONPATH"] = os.pathsep.join(machine.packages(packages))
    env.update(dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(folder)))
    if sys.flags.no_user_site:
        env["PYTHONNOUSERSITE"] = "1"
    env.update(machine.variables())
    return env


def _own_group() -> dict:
    """Arguments of Popen that put the worker into a group of its own, without a console window; on Windows behind the
    window in priority, which the worker sees to itself elsewhere."""
    if os.name == "posix":
        return {"start_new_session": True}
    flags = subprocess.CREATE_NO_WINDOW | subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.BELOW_NORMAL_PRIORITY_CLASS
    return {"creationflags": flags}
