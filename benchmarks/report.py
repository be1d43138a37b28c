"""The page of results from what `compare` measured: `python -m benchmarks.report` with the options of `compare`.

With --report docs/results.md the page goes there, and the rows (CSV), the figures (JSON) and the plots (PNG) to the
folder results beside it; without, all of it goes beside the measured lines in out/bench.
"""

import argparse
import os
import sys
from datetime import date
from pathlib import Path

import numpy as np

from corpus.meshes import Entry
from npm_blender.core.files import write_file
from npm_blender.core.network import load_weights

from . import losses, options, plots, speed, tables, verdict
from .methods import REFERENCE, REFERENCE_SCALARS
from .methods.case import BUDGETS, FEATURES
from .pictures import section
from .results import FLOOR, LEAST, MEASURES, WORSE, Results, load, write_json
from .tables import OURS


def page(results: Results, o: argparse.Namespace, runtime: dict | None, pictures: str, entries: list[Entry]) -> str:
    """The Markdown page. pictures: the folder of the plots, as the page sees it; entries: the meshes."""
    out = ["# Results", "", losses.paragraph(results), "", origin(results, o, pictures), ""]
    out += ["## The verdict", "", *verdict.tables(results, entries), ""]
    out += equal_bytes(results, pictures, entries)
    out += section(o.report) if o.report else []
    out += paper_tables(results, runtime, pictures)
    out += [stages(results), "", failures(results), ""]
    return "\n".join(out)


def origin(results: Results, o: argparse.Namespace, pictures: str) -> str:
    """How and of what the page was made, and the units of its figures."""
    model = load_weights()
    counts = ", ".join(f"{name} {len(results.rows[m])}" for m, name in results.names.items())
    chosen = f"the {o.split} split of {o.corpus.name}" if o.corpus else "meshes that Blender makes"
    return (
        f"Made {date.today()} by `{command(o)}` ({chosen}, {len(results.meshes)} meshes; weights {model.model_id} "
        f"{model.digest.hex()}). Worse way (the larger of d_pm and d_reverse), d_pm, d_reverse and the 99th percentile of "
        f"d_pm's distances: unit cube x 1e-4; d_normal: degrees; {o.samples:,} points each way. Meshes by method: {counts}. A "
        "comparison is over the meshes that both methods have; in brackets how many, where it is not all. Every figure: "
        f"[results.csv]({pictures}/results.csv), [results.json]({pictures}/results.json)."
    )


def equal_bytes(results: Results, pictures: str, entries: list[Entry]) -> list[str]:
    """Lines of the section that compares files of equal size."""
    out = [
        "## Equal bytes",
        "",
        "Whole files, connectivity included; 1 kB is 1,000 bytes. Ours, the paper's model and Progressive Meshes cut one "
        "stream, the others get the best setting for each budget by the worse way. Geometric means over meshes of the ratio "
        f"to QSlim + Draco; below 1 is better than it. In the worse way errors below {FLOOR} count as {FLOOR} on both sides. A "
        "method without a figure cannot get so small.",
        "",
    ]
    for key in MEASURES:
        out += [*tables.byte_ratios(results, key), ""]
    out += [*tables.by_kind(results, entries), ""]
    out += [f"![Every measure over QSlim + Draco's, by bytes]({pictures}/bytes_ratio.png)", ""]
    out += [f"![Errors by bytes]({pictures}/bytes.png)", ""]
    out += ["Meshes that we win and lose, by the worse way:", "", *tables.wins(results), ""]
    out += [f"![Our error over QSlim + Draco's, by mesh]({pictures}/meshes.png)", "", *tables.whole(results), ""]
    return out


def paper_tables(results: Results, runtime: dict | None, pictures: str) -> list[str]:
    """Lines of the section that repeats the paper's tables on the measured meshes."""
    return [
        "## The paper's tables",
        "",
        "With the paper's compression ratio: numbers of the input over numbers sent, 3 a vertex, 8 a latent of the paper's "
        "model, each number of our own stream; connectivity, indices and entropy coding do not count. Arithmetic means, as in "
        "the paper, whose meshes are others.",
        "",
        "1. All methods with as many numbers as the paper's model has in its base mesh and 0, 40 and 400 latents:",
        "",
        *tables.equal_cr(results),
        "",
        "2. The paper's model by latents. Ratio: mean d_pm over QSlim's mean at 400 faces. Bytes: the file, cut after so many.",
        "",
        *tables.by_features(results),
        "",
        "3. The paper's model by level of detail:",
        "",
        *tables.by_level(results),
        "",
        "4. By compression ratio: geometric mean of d_pm over QSlim's with as many numbers.",
        "",
        *tables.cr_curve(results),
        "",
        f"![d_pm by compression ratio]({pictures}/cr.png)",
        "",
        "5. Runtime, beside the fitting peers in one run:",
        "",
        *(speed.table(runtime) if runtime else ["Not measured in this run."]),
        "",
        *tables.seconds(results),
        "",
    ]


def stages(results: Results) -> str:
    """Median seconds of the stages of our encoder."""
    found = [line["stages"] for line in results.about.get(OURS, {}).values() if line.get("stages")]
    if not found:
        return ""
    text = ", ".join(f"{k} {np.median([s.get(k, 0) for s in found]):.2f}" for k in found[0])
    return f"Our encoder by stage, median seconds, one thread: {text}."


def failures(results: Results) -> str:
    """Every row that is missing because something failed, by cause."""
    text = "; ".join(f"{method}, {mesh}: {cause}" for method, mesh, cause in results.errors[:20])
    more = f"; and {len(results.errors) - 20} more" if len(results.errors) > 20 else ""
    return f"Failed: {len(results.errors)}. {text}{more}".strip()


def command(o: argparse.Namespace) -> str:
    """How to make the page again."""
    parts = ["python -m benchmarks.compare"]
    parts += ["CORPUS", f"--split {o.split}"] if o.corpus else []
    parts += ["--quick"] if o.quick else []
    parts += [f"--limit {o.limit}"] if o.limit else []
    parts += [f"--min-faces {o.min_faces}"] if o.min_faces else []
    parts += [f"--report {o.report}"] if o.report else []
    return " ".join(parts)


def figures(results: Results, o: argparse.Namespace, runtime: dict | None) -> dict:
    """What the page shows, as plain data."""
    against = {}
    for method in results.names:
        against[method] = {
            budget: {
                **{key: results.ratio(method, REFERENCE, "bytes", budget, key)[0] for key in MEASURES},
                "worse_without_floor": results.ratio(method, REFERENCE, "bytes", budget, WORSE, LEAST)[0],
                "meshes": results.ratio(method, REFERENCE, "bytes", budget)[1],
                "ours_won_lost": results.wins(OURS, method, "bytes", budget),
            }
            for budget in BUDGETS
        }
    numbers = {
        m: {
            k: dict(zip(("d_pm", "meshes"), results.ratio(m, REFERENCE_SCALARS, "scalars", k, "d_pm"), strict=True))
            for k in FEATURES
        }
        for m in results.names
    }
    return {
        "made": str(date.today()), "command": command(o), "samples": o.samples, "meshes": len(results.meshes),
        "weights": load_weights().digest.hex(), "bytes_ratio_to_qslim_draco": against, "numbers_ratio_to_qslim": numbers,
        "runtime": runtime, "errors": results.errors,
    }  # fmt: skip


def write(o: argparse.Namespace) -> Path:
    """Write the page and what belongs to it; returns the page's path."""
    results = load(o)
    target = o.report or options.folder(o) / "results.md"
    folder = target.parent / "results"
    folder.mkdir(parents=True, exist_ok=True)
    runtime = None
    if o.runtime:
        print("measuring seconds and memory", file=sys.stderr, flush=True)
        runtime = speed.measure(repeats=3 if o.quick else 7, slow=not o.quick)
    write_file(folder / "results.csv", results.csv().encode())
    write_json(folder / "results.json", figures(results, o, runtime))
    plots.write(results, folder)
    shown = os.path.relpath(folder, target.parent)
    write_file(target, page(results, o, runtime, shown, options.meshes(o)).encode())
    return target


def main() -> None:
    """Read the options and write."""
    print(write(options.parse(__doc__)))


if __name__ == "__main__":
    main()
