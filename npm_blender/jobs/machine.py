"""What the worker process may use of the machine: chosen in the preferences, passed by the environment it starts with."""
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ..core.settings import CACHE_VARIABLE
from ..runtime.caches import COMPILED

POOLS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS", "NUMBA_NUM_THREADS")


@dataclass(frozen=True)
class WorkerSettings:
    """threads: of the processor, 0 for as many as suit each step; cache: folder for compiled code and results
    (runtime/caches.py), None for the packages' own."""

    threads: int = 0
    cache: str | None = None

    def variables(self) -> dict[str, str]:
        """The environment variables that say this to the worker and to its libraries."""
        out = dict.fromkeys(POOLS, str(self.threads)) if self.threads else {}
        if self.cache:
            out["NUMBA_CACHE_DIR"] = str(Path(self.cache, COMPILED))
            out[CACHE_VARIABLE] = self.cache
        return out

    @contextmanager
    def in_this_process(self) -> Iterator[None]:
        """Let this process be what the worker would be; as it was before, afterwards."""
        environment = dict(os.environ)
        os.environ.update(self.variables())
        try:
            yield
        finally:
            os.environ.clear()
            os.environ.update(environment)
