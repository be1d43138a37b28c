"""Compress a mesh, measure it, and render what arrives first: files and one contact sheet in a folder.

Without MESH, Blender makes a detailed sculpt to compress. Needs Blender: its Python module, or run inside it.
"""

import argparse
import zlib
from pathlib import Path

from ..core.files import SUFFIX
from ..core.settings import CompressSettings
from . import compress, evaluate
from .console import ProgressLine
from .files import check_input, check_output, open_stream_file

HELP = "compress, measure and render a mesh, by default one that Blender makes"
STOPS = 4  # of the stream, that the first row shows beside the source
SAMPLES = 200_000  # points per direction; steady to about 0.3 %, and a fifth of the time of `evaluate`
WIRE_LEVELS = 3  # finer levels are so dense that their edges would hide the surface
Y_UP = (".obj", ".glb", ".gltf")  # formats in which up is usually y; it matters for the picture only


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's arguments."""
    parser.add_argument("mesh", metavar="MESH", type=Path, nargs="?", help="mesh to use: .ply .obj .off .stl .glb .drc")
    parser.add_argument(
        "--out", metavar="DIR", type=Path, default=Path("out/demo"), help="folder to write to (default %(default)s)"
    )
    parser.add_argument(
        "--up",
        choices=("y", "z"),
        default=None,
        help="the mesh's up axis, for the picture (default: y for .obj and .glb, z for others)",
    )


def run(args: argparse.Namespace) -> None:
    """Run all steps, printing each result as it is there."""
    from ..core.evaluation import thinned
    from ..core.meshio import read_mesh, write_mesh
    from ..demo.blender import require_blender

    if args.mesh is not None:
        check_input(args.mesh)
    require_blender()
    args.out.mkdir(parents=True, exist_ok=True)
    with ProgressLine() as progress:
        source = args.mesh if args.mesh is not None else _sculpt(args.out, progress)
        name = source.stem if args.mesh is not None else "sculpt"
        target = check_output(args.out / f"{name}{SUFFIX}", source, (SUFFIX,))
        summary = compress.compress_file(source, target, CompressSettings(), progress)
        for message in summary["messages"]:
            progress.note(message)
        original, progressive = read_mesh(source), open_stream_file(target)
        top = progressive.levels
        by_features = [(n, top) for n in thinned(progressive.stops, STOPS)]
        by_level = [(progressive.features, level) for level in range(top + 1)]
        rows = evaluate.measure(progressive, original, list(dict.fromkeys(by_features + by_level)), progress, SAMPLES)
        row_at = {(row["features"], row["level"]): row for row in rows}
        meshes = {stop: progressive.decode(*stop) for stop in row_at}
        written = [target]
        files = {f"features_{'all' if n == progressive.features else n}": (n, level) for n, level in by_features}
        files |= {f"level_{level}": (n, level) for n, level in by_level}
        for part, stop in files.items():
            written.append(args.out / f"{name}_{part}.ply")
            write_mesh(written[-1], meshes[stop])
        progress(0.0, "Rendering the contact sheet")
        written.append(args.out / f"{name}.png")
        up = args.up or ("y" if source.suffix.lower() in Y_UP else "z")
        _render(written[-1], original, source.stat().st_size, meshes, row_at, [by_features, by_level], up)
    print(compress.as_text(source, target, summary))
    print()
    print(evaluate.as_text([row_at[stop] for stop in by_features]))
    print()
    print("\n".join(f"wrote {path}" for path in written))


def _sculpt(folder: Path, progress: ProgressLine) -> Path:
    """The file of the default mesh: made once, and again when the code that makes it or Blender changes."""
    import bpy

    from ..core.meshio import write_mesh
    from ..demo import sculpt

    recipe = Path(sculpt.__file__).read_bytes() + bpy.app.version_string.encode()
    path = folder / f"sculpt-{zlib.crc32(recipe):08x}.ply"
    if not path.exists():
        progress(0.0, "Sculpting a mesh to compress")
        write_mesh(path, sculpt.make_sculpt())
    return path


def _render(
    path: Path, original, size: int, meshes: dict, row_at: dict, stops: list[list[tuple[int, int]]], up: str
) -> None:
    """The contact sheet: the source and more and more features in the first row, the levels in the second."""
    from ..demo.sheet import Cell, render_sheet, upright

    def lines(stop: tuple[int, int]) -> tuple[str, ...]:
        return (
            f"{len(meshes[stop].F):,} faces · {row_at[stop]['bytes']:,} bytes",
            f"error {row_at[stop]['worse']:.2f} × 10⁻⁴",
        )

    by_features, by_level = stops
    shown = {stop: upright(mesh, up) for stop, mesh in meshes.items()}
    titles = {features: f"{features:,} features" for features, _ in by_features}
    titles[0], titles[by_features[-1][0]] = "No features", "All features"
    first = [Cell(upright(original, up), "Source", (f"{len(original.F):,} faces", f"{size:,} bytes"))]
    first += [Cell(shown[stop], titles[stop[0]], lines(stop)) for stop in by_features]
    second = [Cell(shown[stop], f"Level {stop[1]}", lines(stop), wire=stop[1] < WIRE_LEVELS) for stop in by_level]
    render_sheet([first, second], path)
