"""Say what an .npmesh file holds: model, faces of base and levels, features, and the bytes at every stop.

A feature is a number of a displaced surface, or a latent of 8 numbers of the paper's model; a stop is how many of them
are worth waiting for, as the end of a stage that halves the steps.
"""

import argparse
from pathlib import Path

from .console import print_json, table
from .files import open_stream_file

HELP = "what an .npmesh file holds"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's arguments."""
    parser.add_argument(
        "input", metavar="IN.npmesh", type=Path, help="file to look at; it may be truncated past the base"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")


def run(args: argparse.Namespace) -> None:
    """Print the summary."""
    progressive = open_stream_file(args.input)
    summary = describe(progressive)
    print_json(summary) if args.json else print(as_text(args.input, summary, progressive.shortfall))


def describe(progressive) -> dict:
    """The summary as a JSON-able dict; `bytes_at` counts whole prefixes of the file, header and base included."""
    return {
        "model": progressive.model,
        "faces": progressive.source_faces,
        "vertices": progressive.source_vertices,
        "base_faces": progressive.base_faces,
        "levels": progressive.levels,
        "faces_per_level": [progressive.faces_at(level) for level in range(progressive.levels + 1)],
        "bytes": progressive.total_bytes,
        "base_bytes": progressive.base_bytes,
        "rungs": [rung._asdict() for rung in progressive.rungs],
        "bytes_at": {str(n): progressive.bytes_for(n) for n in progressive.stops},
        "features": progressive.features,
        "total_features": progressive.total_features,
        "numbers": progressive.numbers(progressive.features),
        "truncated": progressive.truncated,
        "position_bits": progressive.position_bits,
        "corrupt": progressive.corrupt,
    }


def as_text(path: Path, summary: dict, shortfall: str) -> str:
    """The summary for people; shortfall: what is wrong with the file, empty if nothing is."""
    arrived = f"{summary['features']:,}"
    if summary["features"] < summary["total_features"]:
        arrived += f" of {summary['total_features']:,}"
    if summary["numbers"] != summary["features"]:
        arrived += f", {summary['numbers']:,} numbers"
    return "\n".join(
        [
            f"{path}: {summary['bytes']:,} bytes, model {summary['model']}, "
            f"{summary['position_bits']} bits per base coordinate",
            f"source: {summary['faces']:,} faces, {summary['vertices']:,} vertices",
            f"base: {summary['base_faces']:,} faces, {summary['base_bytes']:,} bytes",
            *(f"from {rung['bytes']:,} bytes on: a base of {rung['base_faces']:,} faces, levels 0 to {rung['levels']}"
              for rung in summary["rungs"][1:]),
            f"faces of levels 0 to {summary['levels']}: {', '.join(f'{n:,}' for n in summary['faces_per_level'])}",
            f"features: {arrived}",
            *([f"the file {shortfall}"] if shortfall else []),
            table(("features", "bytes"), [(int(n), size) for n, size in summary["bytes_at"].items()]),
        ]
    )
