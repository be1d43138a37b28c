"""What the worker process may use of the machine: chosen in the preferences, passed by the environment it starts with."""
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ..core.errors import SettingsError
from ..core.settings import CACHE_VARIABLE, ComputeSettings
from ..runtime.caches import COMPILED

DEVICE, THREADS = "NPMESH_DEVICE", "NPMESH_THREADS"
POOLS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS", "NUMBA_NUM_THREADS")


@dataclass(frozen=True)
class WorkerSettings:
    """compute: threads and device; cache: folder for compiled code and results (runtime/caches.py), None for the
    packages' own; torch_path: folder to import torch from where Blender's Python has none, "" for no such folder."""

    compute: ComputeSettings = ComputeSettings()
    cache: str | None = None
    torch_path: str = ""

    def variables(self) -> dict[str, str]:
        """The environment variables that say this to the worker and to its libraries."""
        out = {DEVICE: self.compute.device, THREADS: str(self.compute.threads)}
        if self.compute.threads:
            out.update(dict.fromkeys(POOLS, str(self.compute.threads)))
        if self.compute.device == "gpu":
            out["PYTORCH_ENABLE_MPS_FALLBACK"] = "1"  # what Apple's GPUs cannot do yet is done by the processor
        if self.cache:
            out["NUMBA_CACHE_DIR"] = str(Path(self.cache, COMPILED))
            out[CACHE_VARIABLE] = self.cache
        return out

    def packages(self, own: list[str]) -> list[str]:
        """Where the worker looks for packages: where Blender does, `own`, and only then where torch is."""
        return [*own, self.torch_path] if self.torch_path and self.torch_path not in own else list(own)

    @contextmanager
    def in_this_process(self) -> Iterator[None]:
        """Let this process be what the worker would be; as it was before, afterwards."""
        environment, path = dict(os.environ), list(sys.path)
        os.environ.update(self.variables())
        sys.path[:] = self.packages(path)
        try:
            yield
        finally:
            os.environ.clear()
            os.environ.update(environment)
            sys.path[:] = path


def compute_settings(environment: Mapping[str, str] = os.environ) -> ComputeSettings:
    """The worker's side: threads and device from the environment. Raises SettingsError."""
    threads = environment.get(THREADS, "0")
    if not threads.isdecimal():
        raise SettingsError(f"Expected {THREADS} to be a whole number, found {threads!r}; correct or unset it")
    return ComputeSettings(int(threads), environment.get(DEVICE, "cpu"))
