"""Meshes of a corpus folder: a manifest.csv with the columns name, file, split, faces, and the files beside it."""

import csv
from dataclasses import dataclass
from pathlib import Path

from npm_blender.core.errors import FileError
from npm_blender.core.mesh import TriMesh
from npm_blender.core.meshio import FORMATS, read_mesh

SUFFIXES = tuple(FORMATS)  # of the files that can be read


@dataclass(frozen=True)
class Entry:
    """One mesh of the corpus."""

    name: str
    path: Path
    faces: int
    kind: str

    def read(self) -> TriMesh:
        """The mesh."""
        return read_mesh(self.path)


def entries(folder: Path, split: str) -> list[Entry]:
    """Meshes of a split (train, val or test), smallest first. Raises FileError if the folder has no manifest."""
    manifest = folder / "manifest.csv"
    if not manifest.is_file():
        raise FileError(f"Expected a corpus with manifest.csv in {folder}, found none; give the corpus folder")
    with manifest.open(newline="") as f:
        rows = [row for row in csv.DictReader(f) if row["split"] == split]
    found = [Entry(row["name"], folder / row["file"], int(row["faces"]), row.get("kind", "")) for row in rows]
    return sorted(found, key=lambda e: (e.faces, e.name))
