"""Workers that are forked from a process with everything loaded, where a fresh one loads compiled code for seconds.

What they read, do and say is `npm_blender.jobs.worker`, as ever. How a worker is started, and that it needs nothing but what it
is given, is for tests that take the fixture `own_process` or `as_installed`.
"""
import contextlib
import json
import os
import runpy
import signal
import socket
import subprocess
import sys
import tempfile
import traceback
from pathlib import Path
from types import SimpleNamespace

ROOT = Path(__file__).resolve().parents[2]
POSSIBLE = sys.platform == "linux"  # elsewhere there is no fork, or no socket that keeps messages apart
MOST = 2**20  # bytes of a message


class Workers:
    """Starts workers; the process that they are forked from begins with the first."""

    def __init__(self) -> None:
        self._line: socket.socket | None = None
        self._process: subprocess.Popen | None = None

    def start(self, folder: Path, environment: dict[str, str]) -> "Forked":
        """As `npm_blender.jobs.process.start`."""
        read, write = os.pipe()
        try:
            with open(folder / "out", "wb") as out, open(folder / "err", "wb") as err:
                pid = self.ask([read, out.fileno(), err.fileno()], folder=str(folder), environment=environment)
        finally:
            os.close(read)
        return Forked(self, pid, write)

    def ask(self, files: list[int], **said: object) -> int | None:
        """What the process answers."""
        if self._line is None:
            self._line, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            command = [sys.executable, "-m", "tests.addon.forked_workers", str(its.fileno())]
            self._process = subprocess.Popen(command, cwd=ROOT, pass_fds=[its.fileno()])
            its.close()
        socket.send_fds(self._line, [json.dumps(said).encode()], files)
        return json.loads(self._line.recv(MOST))

    def close(self) -> None:
        """End the process; workers end with their standard input."""
        if self._line is not None:
            self._line.close()
            self._process.wait()


class Forked:
    """A worker: what a job uses of `subprocess.Popen`."""

    def __init__(self, workers: Workers, pid: int, stdin: int) -> None:
        self._workers, self.pid, self.stdin = workers, pid, open(stdin, "wb")
        self.returncode: int | None = None

    def poll(self) -> int | None:
        """The exit code, or None while it runs."""
        if self.returncode is None:
            self.returncode = self._workers.ask([], pid=self.pid, wait=False)
        return self.returncode

    def wait(self) -> int:
        """The exit code, once it has ended."""
        if self.returncode is None:
            self.returncode = self._workers.ask([], pid=self.pid, wait=True)
        return self.returncode

    def kill(self) -> None:
        """End it at once."""
        os.kill(self.pid, signal.SIGKILL)


def _load() -> None:
    """Load compiled code, as it is needed for a mesh; how near a stream is to its mesh is tested elsewhere."""
    from npm_blender.core.codec import compress, receive
    from npm_blender.core.evaluation import measure_prefixes
    from npm_blender.core.settings import CompressSettings, LodSettings
    from tests.few_points import compare_by_few_points
    from tests.meshes.shapes import bumpy

    compare_by_few_points(SimpleNamespace(setattr=setattr))
    received = receive(compress(bumpy(2), CompressSettings(LodSettings(base_faces=60, levels=1)), lambda *said: None).data)
    measure_prefixes(received.open(), bumpy(2))


def _be_worker(folder: str, environment: dict[str, str], files: list[int]) -> None:
    """As the command of `npm_blender.jobs.process` does it."""
    try:
        os.setpgid(0, 0)
        for to, file in enumerate(files):
            os.dup2(file, to)
            os.close(file)
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(environment)
        tempfile.tempdir, sys.argv = None, ["", folder]
        runpy.run_module("npm_blender.jobs.worker", run_name="__main__")
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(1)


def _serve(line: socket.socket) -> None:
    """Answer until the other end closes."""
    while True:
        text, files, *_ = socket.recv_fds(line, MOST, 3)
        if not text:
            return
        said = json.loads(text)
        if files:
            answer = os.fork()
            if answer == 0:
                line.close()
                _be_worker(said["folder"], said["environment"], files)
            with contextlib.suppress(OSError):  # the worker was quicker
                os.setpgid(answer, answer)
            for file in files:
                os.close(file)
        else:
            pid, status = os.waitpid(said["pid"], 0 if said["wait"] else os.WNOHANG)
            answer = os.waitstatus_to_exitcode(status) if pid else None
        line.send(json.dumps(answer).encode())


if __name__ == "__main__":
    _load()
    _serve(socket.socket(fileno=int(sys.argv[1])))
