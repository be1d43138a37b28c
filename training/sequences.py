"""LoD sequences of a folder of meshes, cached for training: `python -m training.sequences MESHES OUT [--variants N]`.

MESHES is a corpus with a manifest.csv (its train and val splits are kept apart), or any folder of mesh files (every
tenth goes to val). OUT/train and OUT/val get one .npz per sequence: V0, F0, V, N, levels. Besides the deterministic
400-face base there are `--variants` random ones (paper: random decimation as augmentation), and every fourth mesh
gets a 100-face base with one more level, so that the last step of the network learns to be repeated.
"""

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from corpus import pool
from corpus.meshes import SUFFIXES, entries
from npm_blender.core.cleaning import clean
from npm_blender.core.errors import FileError
from npm_blender.core.levels import build_lod
from npm_blender.core.mesh import TriMesh, UnitFrame
from npm_blender.core.meshio import read_mesh
from npm_blender.core.settings import PAPER_FACES, PAPER_LEVELS, LodSettings

USUAL = LodSettings(PAPER_FACES, PAPER_LEVELS)
FEW = LodSettings(base_faces=100, levels=4)


@dataclass(frozen=True)
class Task:
    """One sequence to build."""

    name: str
    path: Path
    out: Path
    settings: LodSettings


def tasks(folder: Path, out: Path, variants: int) -> list[Task]:
    """Everything to build for a corpus or a plain folder. Raises FileError if there is no mesh in it."""
    if (folder / "manifest.csv").is_file():
        found = [(e.name, e.path, split) for split in ("val", "train") for e in entries(folder, split)]
    else:
        paths = sorted(p for p in folder.rglob("*") if p.suffix.lower() in SUFFIXES)
        found = [(p.stem, p, "val" if i % 10 == 9 else "train") for i, p in enumerate(paths)]
    if not found:
        raise FileError(f"Expected mesh files in {folder}, found none; give a folder of {' '.join(SUFFIXES)}")
    out_of = {split: out / split for split in ("train", "val")}
    result = [
        Task(f"{split}/{name}", path, out_of[split] / f"{name}.npz", USUAL) for name, path, split in found
    ]
    train = [(name, path) for name, path, split in found if split == "train"]
    for k in range(1, variants + 1):
        result += [
            Task(f"train/{name}.v{k}", path, out_of["train"] / f"{name}.v{k}.npz", replace(USUAL, variant=k))
            for name, path in train
        ]
    result += [
        Task(f"train/{name}.b100", path, out_of["train"] / f"{name}.b100.npz", FEW)
        for name, path in train[::4]
    ]
    return result


def build(task: Task) -> dict:
    """Build and write one sequence."""
    mesh, _ = clean(read_mesh(task.path), "auto")
    lod = build_lod(TriMesh(UnitFrame.of(mesh.V).to_unit(mesh.V), mesh.F), task.settings)
    if not np.isfinite(lod.V).all():
        raise ValueError("positions are not finite")
    temporary = task.out.with_suffix(".tmp.npz")
    np.savez(
        temporary,
        V0=lod.V0.astype(np.float32),
        F0=lod.F0,
        V=lod.V.astype(np.float32),
        N=lod.N.astype(np.float32),
        levels=np.int64(lod.level_count),
    )
    temporary.replace(task.out)
    return {"faces": len(lod.F0), "message": lod.message}


def main() -> None:
    """Read the options and build what is missing."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("meshes", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--variants", type=int, default=1)
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    for split in ("train", "val"):
        (options.out / split).mkdir(parents=True, exist_ok=True)
    pool.run(
        build, tasks(options.meshes, options.out, options.variants), options.out / "built.jsonl", options.processes
    )


if __name__ == "__main__":
    main()
