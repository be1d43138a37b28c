"""Reading .npmesh files in a worker process."""
from pathlib import Path
from typing import TYPE_CHECKING

from ..core.errors import NpmError
from . import protocol
from .job import Job
from .machine import WorkerSettings

if TYPE_CHECKING:
    from ..core.codec import StoredStream


class ReadJob(Job):
    """Read .npmesh files; the result is a StoredStream for each, or the NpmError that says why there is none."""

    def __init__(self, paths: list[Path], scratch: str | None = None,
                 machine: WorkerSettings | None = None) -> None:
        """Start; see Job."""
        super().__init__(lambda folder: protocol.write_paths(folder, paths), scratch, machine)

    def _collect(self, report: list[dict]) -> "list[StoredStream | NpmError]":
        return [protocol.error_in(said) if "error" in said else protocol.read_received(self._folder, k)
                for k, said in enumerate(report)]
