"""Decode an .npmesh file, or the part of it that a budget allows, into an ordinary mesh file."""

import argparse
import time
from pathlib import Path

from .console import ProgressLine, print_json
from .files import MESH_SUFFIXES, check_input, check_output, open_stream_file
from .selection import FEATURES_HELP, check_level, count_type, features_type, features_within, number_of_features

HELP = ".npmesh -> mesh file"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's arguments."""
    parser.add_argument(
        "input", metavar="IN.npmesh", type=Path, help="file to decode; it may be truncated past the base"
    )
    parser.add_argument("output", metavar="OUT", type=Path, help=f"mesh to write: {' '.join(MESH_SUFFIXES)}")
    much = parser.add_mutually_exclusive_group()
    much.add_argument(
        "--features", metavar="N|all", type=features_type, default=None, help=f"{FEATURES_HELP} (default all)"
    )
    much.add_argument(
        "--bytes", metavar="B", type=count_type, default=None, help="use only the first B bytes of the file"
    )
    parser.add_argument(
        "--level",
        metavar="L",
        type=count_type,
        default=None,
        help="level of detail, 0 is the base (default: the finest)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")


def run(args: argparse.Namespace) -> None:
    """Decode, write the mesh, and print what was used."""
    from ..core.meshio import write_mesh

    check_input(args.input)
    check_output(args.output, args.input, MESH_SUFFIXES)
    with ProgressLine() as progress:
        progress(0.0, f"Decoding {args.input.name}")
        start = time.perf_counter()
        progressive = open_stream_file(args.input)
        level = check_level(progressive, args.level)
        if args.bytes is not None:
            features = features_within(progressive, args.bytes)
        else:
            features = number_of_features(progressive, args.features, progress.note)
        if progressive.shortfall:
            progress.note(f"{args.input} {progressive.shortfall}")
        mesh = progressive.decode(features=features, level=level)
        decoded = time.perf_counter()
        progress(0.9, f"Writing {args.output.name}")
        write_mesh(args.output, mesh)
        summary = {
            "features": features,
            "level": level,
            "bytes": progressive.bytes_for(features),
            "vertices": len(mesh.V),
            "faces": len(mesh.F),
            "seconds": {"decode": round(decoded - start, 4), "write": round(time.perf_counter() - decoded, 4)},
        }
    if args.json:
        print_json(summary)
    else:
        print(
            f"{args.output}: {summary['faces']:,} faces, level {level}, from {features:,} features "
            f"({summary['bytes']:,} of {progressive.total_bytes:,} bytes)"
        )
