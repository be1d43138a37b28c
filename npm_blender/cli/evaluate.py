"""Measure decoded meshes against the original, with the paper's definitions (its section 4.1).

d_pm: mean distance of the decoded mesh to the original, x1e-4, in the original's unit cube; d_normal: mean angle
between their normals, degrees; d_reverse: mean distance of the original to the decoded mesh, x1e-4; worse: the
larger of both distances. CR counts numbers, as the paper does: 3 |V| / (3 |V0| + numbers); `bytes` counts the file.
"""

import argparse
from pathlib import Path

from .console import ProgressLine, print_json, table
from .files import check_input, open_stream_file
from .selection import check_level, count_type, features_list_type, number_of_features

HELP = "bytes, compression ratio and errors against the original"
SAMPLES = 1_000_000  # points per direction: the mean is then steady to about 0.1 %
COLUMNS = ("features", "level", "bytes", "cr", "d_pm", "d_normal", "d_reverse", "worse")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the verb's arguments."""
    parser.add_argument("input", metavar="IN.npmesh", type=Path, help="file to measure")
    parser.add_argument("original", metavar="ORIGINAL", type=Path, help="mesh that it was made from")
    parser.add_argument(
        "--features",
        metavar="LIST",
        type=features_list_type,
        help="numbers of features, separated by commas (default: the stops of the file, see info)",
    )
    parser.add_argument(
        "--level", metavar="L", type=count_type, default=None, help="level of detail (default: the finest)"
    )
    parser.add_argument("--json", action="store_true", help="print a JSON list of objects instead of a table")


def run(args: argparse.Namespace) -> None:
    """Measure and print one row per number of features."""
    from ..core.meshio import read_mesh

    check_input(args.original)
    with ProgressLine() as progress:
        progressive = open_stream_file(args.input)
        level = check_level(progressive, args.level)
        if progressive.shortfall:
            progress.note(f"{args.input} {progressive.shortfall}")
        progress(0.0, f"Reading {args.original.name}")
        original = read_mesh(args.original)
        chosen = progressive.stops if args.features is None else args.features
        stops = [(number_of_features(progressive, wanted, progress.note), level) for wanted in chosen]
        rows = measure(progressive, original, stops, progress, SAMPLES)
    print_json(rows) if args.json else print(as_text(rows))


def measure(progressive, original, stops: list[tuple[int, int]], progress, samples: int) -> list[dict]:
    """One dict with the keys COLUMNS for each (features, level) of `stops`.

    original: TriMesh; samples: points per direction. Raises MeshError if the original has no area.
    """
    from ..core.evaluation import Original, compression_ratio

    progress(0.0, "Preparing the original")
    reference = Original(original, samples)
    rows = []
    for k, (features, level) in enumerate(stops):
        progress(k / len(stops), f"Measuring {features} features at level {level}")
        error = reference.evaluate(progressive.decode(features=features, level=level))
        rows.append(
            {
                "features": features,
                "level": level,
                "bytes": progressive.bytes_for(features),
                "cr": compression_ratio(len(original.V), progressive.base_vertices, progressive.numbers(features)),
                "d_pm": float(error.d_pm),
                "d_normal": float(error.d_normal),
                "d_reverse": float(error.d_reverse),
                "worse": float(error.worse),
            }
        )
    return rows


def as_text(rows: list[dict]) -> str:
    """The rows as a table for people."""
    header = ("features", "level", "bytes", "CR", "d_pm x1e-4", "d_normal deg", "d_reverse x1e-4", "worse way x1e-4")
    return table(header, [[row[c] for c in COLUMNS] for row in rows])
