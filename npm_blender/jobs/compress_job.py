"""Compressing meshes in a worker process, one after the other."""
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..core.errors import NpmError
from ..core.settings import CompressSettings
from . import protocol
from .job import Job
from .machine import WorkerSettings

if TYPE_CHECKING:
    from ..core.codec import StoredStream
    from ..core.mesh import TriMesh


@dataclass(frozen=True)
class CompressedFile:
    """stream: the compressed mesh, read again; report: the fields of the core's CompressReport; seconds: all of it."""

    stream: "StoredStream"
    report: dict
    seconds: float


class CompressJob(Job):
    """Compress meshes one after the other, in one process; one that fails does not stop the others.

    `add` or `refuse` each of them, in order. The result is a list with, for each mesh, a CompressedFile, or the NpmError
    or WorkerCrash that says why there is none.
    """

    def __init__(self, seconds: Sequence[float], scratch: str | None = None,
                 machine: WorkerSettings | None = None) -> None:
        """Start; see Job. seconds: what each of the meshes will take, estimated, which makes their shares of `fraction`."""
        super().__init__(lambda folder: None, scratch, machine)
        self._shares = [max(s, 1e-3) / sum(max(s, 1e-3) for s in seconds) for s in seconds]
        self._outcomes: list[CompressedFile | Exception | int | None] = [None] * len(self._shares)
        self._added = 0
        self._began = time.perf_counter()

    @property
    def position(self) -> int:
        """Index of the mesh that is being compressed; the number of meshes at the end."""
        return next((k for k, outcome in enumerate(self._outcomes) if outcome is None), len(self._outcomes))

    def add(self, mesh: "TriMesh", settings: CompressSettings) -> None:
        """The next mesh."""
        protocol.write_mesh(self._folder, self._added, mesh, settings)
        self._added += 1
        self._tell(self._added - 1)

    def refuse(self, error: NpmError) -> None:
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

    def result(self) -> list[CompressedFile | Exception]:
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
            self._outcomes[k] = protocol.error_in(said)
        else:
            took = time.perf_counter() - self._began
            self._outcomes[k] = CompressedFile(protocol.read_received(self._folder, k), said["report"], took)
        self._began = time.perf_counter()
