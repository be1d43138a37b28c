"""Loading every package in a worker process, to see which are there and which work."""
from . import protocol
from .job import Job
from .machine import WorkerSettings


class CheckJob(Job):
    """Load every package that the worker uses; the result is `runtime.packages.loaded()` of that process."""

    def __init__(self, scratch: str | None = None, machine: WorkerSettings | None = None) -> None:
        """Start; see Job."""
        super().__init__(protocol.ask_for_check, scratch, machine)

    def _collect(self, report: list[dict]) -> list[dict]:
        return report
