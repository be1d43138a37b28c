"""Compress a mesh file (.ply .obj .off .stl .glb .drc) into a progressive .npmesh file."""

import argparse
import dataclasses
import time
from pathlib import Path

from ..core.errors import SettingsError
from ..core.files import SUFFIX, write_file
from ..core.settings import AUTO, CLEAN_MODES, MODELS, PAPER_FACES, PAPER_LEVELS, CompressSettings, LodSettings
from .console import ProgressLine, print_json
from .files import check_input, check_output

HELP = "mesh file -> .npmesh"


def number_or_auto(text: str) -> int:
    """A whole number, or AUTO for auto. Raises ArgumentTypeError for what is neither."""
    if text == "auto":
        return AUTO
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"Expected a whole number or auto, found {text!r}") from None


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's arguments."""
    lod, whole = LodSettings(), CompressSettings()
    parser.add_argument("input", metavar="IN", type=Path, help="mesh to read: .ply .obj .off .stl .glb .drc")
    parser.add_argument("output", metavar="OUT.npmesh", type=Path, help="file to write")
    parser.add_argument(
        "--model",
        choices=MODELS,
        default=whole.model,
        help=f"displaced: detail as moves along normals; paper: latents and a network, {PAPER_FACES} base faces and "
        f"{PAPER_LEVELS} levels if not told otherwise (default %(default)s)",
    )
    parser.add_argument(
        "--base-faces",
        metavar="N",
        type=number_or_auto,
        default=lod.base_faces,
        help="faces of the base mesh, or auto: what suits the mesh, or the size that --bytes gives (default auto)",
    )
    parser.add_argument(
        "--levels",
        metavar="L",
        type=number_or_auto,
        default=lod.levels,
        help="subdivisions of the base, 1 to 6, or auto: fewer for a large base; each has four times the faces (default auto)",
    )
    parser.add_argument(
        "--bytes",
        metavar="B",
        type=int,
        help="most bytes of the file; what is auto is then what shows most for them",
    )
    parser.add_argument(
        "--clean",
        choices=CLEAN_MODES,
        default=lod.clean,
        help="auto repairs what needs it, off refuses such input, tetwild always re-meshes (default %(default)s)",
    )
    parser.add_argument(
        "--position-bits",
        metavar="B",
        type=number_or_auto,
        default=whole.position_bits,
        help="bits per base coordinate, 4 to 20, or auto: as many as the mesh's error asks for (default auto)",
    )
    parser.add_argument(
        "--order",
        choices=("gain", "magnitude"),
        default=whole.order,
        help="of --model paper: what makes a feature important, measured gain or its magnitude (default %(default)s)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")


def run(args: argparse.Namespace) -> None:
    """Compress, write the file, and print what was done."""
    if args.bytes is not None and not args.bytes:
        raise SettingsError("Expected --bytes to be above 0, found 0; leave it out for a file with all features")
    settings = CompressSettings(
        lod=LodSettings(base_faces=args.base_faces, levels=args.levels, clean=args.clean),
        position_bits=args.position_bits,
        model=args.model,
        order=args.order,
        budget=args.bytes or 0,
    )
    check_input(args.input)
    check_output(args.output, args.input, (SUFFIX,))
    with ProgressLine() as progress:
        summary = compress_file(args.input, args.output, settings, progress)
        for message in summary["messages"]:
            progress.note(message)
    if args.json:
        print_json(summary)
    else:
        print(as_text(args.input, args.output, summary))


def compress_file(source: Path, target: Path, settings: CompressSettings, progress: ProgressLine) -> dict:
    """Read `source`, compress it and write `target` atomically; the report as a JSON-able dict.

    `seconds` has read, and the stages that the codec reports, from clean to write.
    Raises the NpmError family and OSError; then `target` is as it was.
    """
    from ..core.meshio import read_mesh

    progress(0.0, f"Reading {source.name}")
    start = time.perf_counter()
    mesh = read_mesh(source)
    seconds = {"read": time.perf_counter() - start}
    from ..core.codec import compress  # after reading: a file that cannot be read is reported at once

    done = compress(mesh, settings, progress)
    start = time.perf_counter()
    write_file(target, done.data)
    wrote = time.perf_counter() - start
    seconds.update(done.report.seconds)
    seconds["write"] = seconds.get("write", 0.0) + wrote
    summary = dataclasses.asdict(done.report)
    return {
        **summary,
        "messages": list(done.report.messages),
        "seconds": {k: round(float(s), 4) for k, s in seconds.items()},
    }


def as_text(source: Path, target: Path, summary: dict) -> str:
    """The report as three lines for people."""
    size = source.stat().st_size
    share = 100 * summary["bytes"] / max(size, 1)
    stages = ", ".join(f"{name} {took:.2f}" for name, took in summary["seconds"].items())
    return "\n".join(
        [
            f"{source}: {summary['faces']:,} faces, {size:,} bytes; cleaning: {summary['cleaning']}",
            f"{target}: {summary['base_faces']:,} base faces, {summary['levels']} levels, "
            f"{summary['features']:,} features, {summary['bytes']:,} bytes ({share:.2f} % of the input file)",
            f"seconds: {stages}",
        ]
    )
