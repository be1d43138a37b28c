"""Remeshing as the surface of a solid with TetWild: the last resort for meshes that nothing gentler repairs.

It runs in a process of its own, because it takes minutes, cannot be interrupted, and drops a file into the current
folder; the process works in a temporary folder and is ended on a cancel or after LIMIT seconds. Two runs differ, so
that the first result is kept in the user's cache folder, by a hash of the input, and is taken again.
"""
import importlib.metadata
import importlib.util
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from ..errors import DependencyError, MeshError
from ..mesh import TriMesh
from ..progress import Progress, no_progress
from . import result_cache

LIMIT = 900.0  # seconds; 12k faces take 10 to 16 s, and time grows with damage more than with size
ENVELOPE = 1e-3  # of the box's diagonal: how far the result may be from the input
PROGRAM = """
import sys
import numpy as np
import pytetwild
V, F, epsilon = np.load("V.npy"), np.load("F.npy"), float(sys.argv[1])
V, T = pytetwild.tetrahedralize(V, F, epsilon=epsilon, optimize=True, num_threads=1, quiet=True)
np.save("tetrahedra.npy", np.asarray(T, np.int64))
np.save("points.npy", np.asarray(V, np.float64))
"""


def remesh(V: np.ndarray, F: np.ndarray, progress: Progress = no_progress,
           limit: float = LIMIT) -> tuple[np.ndarray, np.ndarray, bool]:
    """The boundary (V, F) of the solid that V (n, 3), F (m, 3) enclose by winding number, within ENVELOPE; was it kept?

    Oriented outward; it may still touch itself in edges or vertices. The same input gives the same output as long as
    the cache folder holds the first; True then. Raises DependencyError without pytetwild, MeshError if it fails,
    encloses nothing or needs more than `limit` seconds, and Cancelled.
    """
    if importlib.util.find_spec("pytetwild") is None:
        raise DependencyError("Expected the package pytetwild for TetWild, found none; "
                              "run pip install pytetwild==0.2.3, or use --clean auto")
    V, F = np.ascontiguousarray(V, np.float64), np.ascontiguousarray(F, np.int32)
    folder = result_cache.user_cache() / "tetwild"
    key = result_cache.digest(importlib.metadata.version("pytetwild"), PROGRAM, repr(ENVELOPE), V, F)
    kept = result_cache.load(folder, key)
    mesh = _checked(kept) if kept else None
    if mesh:
        return mesh.V, mesh.F, True
    with tempfile.TemporaryDirectory(prefix="npm-tetwild-") as work:
        np.save(Path(work, "V.npy"), V)
        np.save(Path(work, "F.npy"), F)
        _run(work, progress, limit)
        P, T = np.load(Path(work, "points.npy")), np.load(Path(work, "tetrahedra.npy"))
    F = _boundary(P, T)
    if len(F) == 0:
        raise MeshError("Expected TetWild to find a solid, found none; the mesh encloses no volume, use --clean auto")
    used, F = np.unique(F, return_inverse=True)
    P, F = P[used], F.reshape(-1, 3).astype(np.int32)
    result_cache.keep(folder, key, V=P, F=F)
    return P, F, False


def _checked(arrays: dict[str, np.ndarray]) -> TriMesh | None:
    """The mesh of a cache entry, if it holds one."""
    try:
        return TriMesh.from_arrays(arrays["V"], arrays["F"])
    except (KeyError, MeshError):
        return None


def _run(folder: str, progress: Progress, limit: float) -> None:
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(p for p in sys.path if p))
    with open(Path(folder, "log"), "wb") as log:
        process = subprocess.Popen([sys.executable, "-c", PROGRAM, str(ENVELOPE)], cwd=folder, env=environment,
                                   stdin=subprocess.DEVNULL, stdout=log, stderr=log)
    try:
        start = time.monotonic()
        while True:
            try:
                process.wait(0.2)
                break
            except subprocess.TimeoutExpired:
                elapsed = time.monotonic() - start
                progress(elapsed / (elapsed + 30), f"Remeshing with TetWild, {elapsed:.0f} s")
                if elapsed > limit:
                    raise MeshError(f"Expected TetWild to end within {limit:.0f} s, found it still running; "
                                    "use --clean auto, or reduce the mesh first") from None
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
    if process.returncode or not Path(folder, "points.npy").exists():
        lines = Path(folder, "log").read_text(errors="replace").strip().splitlines() or [f"code {process.returncode}"]
        raise MeshError(f"Expected TetWild to remesh, found that it failed ({lines[-1][:100]}); use --clean auto")


def _boundary(P: np.ndarray, T: np.ndarray) -> np.ndarray:
    """Faces (m, 3) int32 of tetrahedra T (t, 4) that belong to one of them only, seen from outside."""
    T = T[:, :4]
    F = T[:, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]].reshape(-1, 3)
    a, b, c = P[F].swapaxes(0, 1)
    inside = np.repeat(P[T].mean(1), 4, 0)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), inside - a) > 0
    F = np.where(inward[:, None], F[:, ::-1], F)
    _, first, count = np.unique(np.sort(F, 1), axis=0, return_index=True, return_counts=True)
    return F[np.sort(first[count == 1])].astype(np.int32)
