"""What the pictures show: the demo's sculpt and its compressed stream, in out/shots. Needs the demo's requirements.

    .venv/bin/python docs/shots/prepare.py

Compresses again only if the present weights cannot open the stream.
"""
import argparse
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from npm_blender.core.codec import open_stream, receive  # noqa: E402 - found in ROOT
from npm_blender.core.errors import NpmError  # noqa: E402 - found in ROOT
from npm_blender.core.evaluation import measure_prefixes  # noqa: E402
from npm_blender.core.files import write_file  # noqa: E402
from npm_blender.core.mesh import TriMesh  # noqa: E402

FOLDER = ROOT / "out" / "shots"


def sculpt() -> TriMesh:
    """The demo's sculpt, made by Blender's module the first time."""
    path = FOLDER / "sculpt.npz"
    if not path.exists():
        from npm_blender.demo.sculpt import make_sculpt

        mesh = make_sculpt()
        with open(path.with_suffix(".part"), "wb") as file:
            np.savez(file, V=mesh.V, F=mesh.F)
        path.with_suffix(".part").replace(path)
    with np.load(path, allow_pickle=False) as arrays:
        return TriMesh.from_arrays(arrays["V"], arrays["F"])


def is_current(path: Path) -> bool:
    """Whether the stream at `path` opens with the present weights."""
    try:
        open_stream(path.read_bytes())
    except (OSError, NpmError):
        return False
    return True


def main() -> None:
    """Make what is missing."""
    argparse.ArgumentParser(description=__doc__.split("\n")[0]).parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)
    mesh = sculpt()
    path = FOLDER / "sculpt.npmesh"
    if not is_current(path):
        from npm_blender.core.codec import compress

        write_file(path, compress(mesh).data)
    stored = receive(path.read_bytes())
    write_file(path.with_suffix(".arrays"), stored.arrays)
    write_file(path.with_suffix(".measured"), measure_prefixes(stored.open(), mesh).to_text().encode())
    print(f"{path.relative_to(ROOT)}: {len(mesh.F):,} faces in {path.stat().st_size:,} bytes")


if __name__ == "__main__":
    main()
