"""The whole path from a damaged mesh to levels, in a process of its own that is killed when it takes too long."""
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass

import numpy as np

from npm_blender.core.cleaning.cleanup import CleanReport, clean
from npm_blender.core.errors import NpmError
from npm_blender.core.levels.lod_sequence import LodSequence, build_lod
from npm_blender.core.mesh.triangle_mesh import TriMesh, UnitFrame
from npm_blender.core.settings import LodSettings

BASE, LEVELS = 100, 2


@dataclass(frozen=True)
class Run:
    """dirty: the input; cleaned: in the unit frame; frame: of cleaned."""

    dirty: TriMesh
    cleaned: TriMesh
    frame: UnitFrame
    report: CleanReport
    lod: LodSequence


def whole_path(make) -> Run | str:
    """Make a mesh, clean it and build its levels; the line of an NpmError instead. Other errors are raised."""
    try:
        dirty = make()
        cleaned, report = clean(dirty)
        frame = UnitFrame.of(cleaned.V)
        unit = TriMesh(frame.to_unit(cleaned.V), cleaned.F)
        return Run(dirty, unit, frame, report, build_lod(unit, LodSettings(base_faces=BASE, levels=LEVELS)))
    except NpmError as error:
        return str(error)


def run_case(name: str) -> Run | str:
    """`whole_path` of the damage `name`."""
    from tests.dirty import DIRTY, REFUSED

    return whole_path(DIRTY[name].make if name in DIRTY else REFUSED[name].make)


class Worker:
    """One process for many runs; killed, and started again, when a run takes longer than its limit."""

    def __init__(self) -> None:
        self._pool = None

    def call(self, limit: float, function, *arguments):
        """function(*arguments) in the process. Raises TimeoutError after `limit` seconds, and what function raises."""
        if self._pool is None:
            self._pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"))
        future = self._pool.submit(function, *arguments)
        try:
            return future.result(limit)
        except (TimeoutError, BrokenProcessPool):
            self.stop()
            raise

    def stop(self) -> None:
        """Kill the process."""
        if self._pool is not None:
            for process in list(self._pool._processes.values()):
                process.kill()
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None


def turned_share(lod: LodSequence, F: np.ndarray) -> float:
    """Share of faces F of the finest level whose normal points against the mapped normals of their corners."""
    return float(((TriMesh(lod.V, F).face_normals() * lod.N[F].sum(1)).sum(1) < 0).mean())
