"""Pictures at equal bytes, rendered by Blender: the input, ours, QSlim + Draco and Progressive Meshes side by side.

    python -m benchmarks.pictures [CORPUS] [--meshes springer:y,squirrel:y,gear:y] [--bytes 2000] [--out docs/images]

One picture a mesh, compare_NAME.png. Without a corpus the meshes are those that Blender makes. Without --meshes they
are three of the set, spread over its sizes; NAME:y is a mesh whose up axis is y. The pictures in docs/images are of the
meshes named above, whose licence (MIT) allows it.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from corpus.meshes import Entry
from npm_blender.core.errors import NpmError, SettingsError

from . import methods, options
from .methods.case import Case, Coded

METHODS = ("ours", "qslim_draco", "progressive_meshes")
SHOWN = 3  # meshes
BUDGET = 2_000  # bytes
FOLDER = Path("docs/images")
LARGEST = 300_000  # bytes of a picture
COLOURS = (256, 128, 64, 32)


@dataclass(frozen=True)
class Subject:
    """A mesh to show. up: its up axis, y or z."""

    entry: Entry
    up: str


def chosen(entries: list[Entry], names: str | None) -> list[Subject]:
    """The meshes named `a,b:y`, or three spread over the sizes. Raises SettingsError for a name that is not there."""
    if not names:
        last = len(entries) - 1
        spread = dict.fromkeys(round(last * (i + 1) / SHOWN) for i in range(SHOWN))
        return [Subject(entries[i], "z") for i in spread]
    known = {entry.name: entry for entry in entries}
    subjects = []
    for item in names.split(","):
        name, _, up = item.partition(":")
        if name not in known or up not in ("", "y", "z"):
            raise SettingsError(f"Expected a mesh of the set, as NAME, NAME:y or NAME:z, found {item}; see its manifest.csv")
        subjects.append(Subject(known[name], up or "z"))
    return subjects


def results(case: Case, budget: int, modules: Sequence[ModuleType]) -> list[tuple[str, Coded | None]]:
    """Name of each method, and what it makes of the mesh within so many bytes."""
    return [(module.NAME, module.at_bytes(case, (budget,))[0]) for module in modules]


def picture(case: Case, found: list[tuple[str, Coded | None]], up: str, path: Path) -> None:
    """Render the input and what the methods made into the PNG `path`; a method without a result leaves no cell."""
    from npm_blender.demo.sheet import Cell, render_sheet, upright

    row = [Cell(upright(case.mesh, up), "Input", (f"{len(case.mesh.F):,} faces",))]
    for name, coded in found:
        if coded is None:
            continue
        error = case.original.evaluate(coded.mesh).worse
        lines = (f"{coded.bytes:,} bytes · {len(coded.mesh.F):,} faces", f"error {error:.2f} × 10⁻⁴")
        row.append(Cell(upright(coded.mesh, up), name[:1].upper() + name[1:], lines))
    temporary = path.with_name(f".{path.name}")
    render_sheet([row], temporary)
    shrink(temporary)
    os.replace(temporary, path)


def shrink(path: Path) -> None:
    """Fewer colours, as few as it takes for the PNG to be smaller than LARGEST."""
    from PIL import Image

    with Image.open(path) as whole:
        rgb = whole.convert("RGB")
    for colours in COLOURS:
        rgb.quantize(colours, kmeans=3).save(path, optimize=True)
        if path.stat().st_size < LARGEST:
            return


def section(page: Path, folder: Path = FOLDER) -> list[str]:
    """Lines of Markdown with the pictures in `folder`, for the page at `page`; empty if there are none."""
    found = sorted(folder.glob("compare_*.png"))
    if not found:
        return []
    seen = [(path.stem.removeprefix("compare_"), Path(os.path.relpath(path, page.parent)).as_posix()) for path in found]
    lines = [f"![{name}: the input and three methods at equal bytes]({path})" for name, path in seen]
    return ["The same bytes, as pictures (`python -m benchmarks.pictures`):", "", *(x for line in lines for x in (line, ""))]


def main() -> None:
    """Read the options, code the meshes, render."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("corpus", type=Path, nargs="?", help="folder with manifest.csv; without one Blender makes meshes")
    parser.add_argument("--split", default="test")
    parser.add_argument("--meshes", help="names, comma-separated")
    parser.add_argument("--bytes", type=int, default=BUDGET)
    parser.add_argument("--out", type=Path, default=FOLDER)
    parser.set_defaults(quick=False, limit=None, min_faces=0)  # of `options.meshes`: all of the set
    o = parser.parse_args()
    try:
        o.out.mkdir(parents=True, exist_ok=True)
        subjects = chosen(options.meshes(o), o.meshes)
        modules = [methods.load(name) for name in METHODS]
        for subject in subjects:
            case = Case.of(subject.entry.name, subject.entry.read())
            found = results(case, o.bytes, modules)
            for name in (name for name, coded in found if coded is None):
                print(f"{case.name}: {name} has nothing of {o.bytes:,} bytes", file=sys.stderr)
            path = o.out / f"compare_{case.name}.png"
            picture(case, found, subject.up, path)
            print(f"wrote {path}, {path.stat().st_size:,} bytes")
    except NpmError as error:
        parser.error(str(error))


if __name__ == "__main__":
    main()
