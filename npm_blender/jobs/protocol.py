"""What the two processes of a job write for each other, as files in the job's folder and as lines.

To the worker, either paths.json, the names of .npmesh files to read; or `check`, to load every package and report; or, on
standard input, one number k a line for each mesh to compress, with mesh<k>.npz, that is, V (n, 3) and F (m, 3), and
mesh<k>.json, the fields of CompressSettings. What it may use of the machine is in its environment (machine.py).

From the worker, 0.npmesh, 0.npz and 0.measured, 1.npmesh ...: streams, what was read from them and how far they are from
the mesh; and on standard output one JSON object a line: {"fraction", "message"} while it runs, then {"report"} or
{"error", "message"}, for each mesh or for all files together. It ends when its standard input closes, that is, with the
program that started it.
"""
import dataclasses
import json
from pathlib import Path
from typing import TYPE_CHECKING

from ..core import errors
from ..core.settings import CompressSettings, LodSettings

if TYPE_CHECKING:
    from ..core.codec import StoredStream
    from ..core.mesh import TriMesh

PATHS, CHECK = "paths.json", "check"


def write_mesh(folder: Path, k: int, mesh: "TriMesh", settings: CompressSettings) -> None:
    """Put the k-th mesh that is to be compressed into `folder`."""
    import numpy as np

    np.savez(folder / f"mesh{k}.npz", V=mesh.V, F=mesh.F)
    (folder / f"mesh{k}.json").write_text(json.dumps(dataclasses.asdict(settings)), encoding="utf-8")


def take_mesh(folder: Path, k: int) -> "tuple[TriMesh, CompressSettings]":
    """What `write_mesh` put there; the mesh is not needed in `folder` afterwards."""
    import numpy as np

    from ..core.mesh import TriMesh

    with np.load(folder / f"mesh{k}.npz", allow_pickle=False) as arrays:
        mesh = TriMesh.from_arrays(arrays["V"], arrays["F"])
    (folder / f"mesh{k}.npz").unlink()
    fields = json.loads((folder / f"mesh{k}.json").read_text(encoding="utf-8"))
    return mesh, CompressSettings(**{**fields, "lod": LodSettings(**fields["lod"])})


def write_paths(folder: Path, paths: list[Path]) -> None:
    """Put the names of the files that are to be read into `folder`."""
    (folder / PATHS).write_text(json.dumps([str(path.absolute()) for path in paths]), encoding="utf-8")


def read_paths(folder: Path) -> list[Path] | None:
    """What `write_paths` put there; None for a job that reads no files."""
    if not (folder / PATHS).exists():
        return None
    return [Path(path) for path in json.loads((folder / PATHS).read_text(encoding="utf-8"))]


def ask_for_check(folder: Path) -> None:
    """Let the worker load every package and report."""
    (folder / CHECK).touch()


def is_check(folder: Path) -> bool:
    """Whether the packages are to be loaded and reported."""
    return (folder / CHECK).exists()


def write_received(folder: Path, k: int, received: "StoredStream") -> None:
    """Put the k-th stream and what was read from it into `folder`."""
    (folder / f"{k}.npmesh").write_bytes(received.data)
    (folder / f"{k}.npz").write_bytes(received.arrays)
    (folder / f"{k}.measured").write_text(received.measured, encoding="utf-8")


def read_received(folder: Path, k: int) -> "StoredStream":
    """What `write_received` put there."""
    from ..core.codec import StoredStream

    return StoredStream((folder / f"{k}.npmesh").read_bytes(), (folder / f"{k}.npz").read_bytes(),
                    (folder / f"{k}.measured").read_text(encoding="utf-8"))


def line_of(**fields: object) -> str:
    """One line of the worker's output."""
    return json.dumps(fields) + "\n"


def fields_of(line: str) -> dict:
    """The inverse of `line_of`."""
    return json.loads(line)


def described(error: errors.NpmError) -> dict[str, str]:
    """The fields that tell of an error."""
    return {"error": type(error).__name__, "message": str(error)}


def error_in(said: dict) -> errors.NpmError:
    """The inverse of `described`."""
    return getattr(errors, said["error"])(said["message"])
