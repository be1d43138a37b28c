"""The LoD builder on a corpus: is every sequence valid, how far is the finest level from the input, what does it cost.

    python -m benchmarks.lod CORPUS [--report docs/lod.md] [--processes 2]

Validity on all meshes of every split, the floor (error of M^3 with nothing lost, fitted and sampled) on the val split,
what it costs beside libigl's qslim (see lodcost.py). Resumes; results lie in out/lod/.
"""

import argparse
import re
import time
from collections import Counter
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import numpy as np

from corpus import pool
from corpus.meshes import Entry, entries
from npm_blender.core.cleaning import clean
from npm_blender.core.decimation import decimate
from npm_blender.core.evaluation import Original
from npm_blender.core.geometry import vertex_normals
from npm_blender.core.levels import build_levels
from npm_blender.core.mesh import TriMesh, UnitFrame, hierarchy, opposite_halfedges, topology_of, vertex_fans

from .lodcost import BASE_FACES, LEVELS, table

SPLITS = ("train", "val", "test")


@dataclass(frozen=True)
class Task:
    """One mesh; floor: whether errors are measured as well."""

    name: str
    entry: Entry
    floor: bool


def border_length(V: np.ndarray, F: np.ndarray, opposite: np.ndarray) -> float:
    """Summed length of the border edges."""
    h = np.flatnonzero(opposite == np.arange(F.size))
    a, b = F.reshape(-1)[h], F.reshape(-1)[h - h % 3 + (h + 1) % 3]
    return float(np.linalg.norm(V[a] - V[b], axis=1).sum())


def flipped(V: np.ndarray, N: np.ndarray, F: np.ndarray) -> float:
    """Share of faces that oppose the input's normals N at their corners."""
    return float(((TriMesh(V[: F.max() + 1], F).face_normals() * N[F].sum(1)).sum(1) < 0).mean())


def measure(task: Task) -> dict:
    """Row of one mesh."""
    mesh, report = clean(task.entry.read(), "auto")
    unit = TriMesh(UnitFrame.of(mesh.V).to_unit(mesh.V), mesh.F)
    begun = time.process_time()
    decimation = decimate(unit, BASE_FACES)
    middle = time.process_time()
    lod = build_levels(decimation, LEVELS)
    seconds = (middle - begun, time.process_time() - middle)
    source, base = topology_of(unit.F), topology_of(lod.F0)
    levels = hierarchy(lod.F0, len(lod.V0), LEVELS)
    finest = levels[-1].F
    row = {
        "faces": len(unit.F),
        "base_faces": len(lod.F0),
        "message": lod.message,
        "cleaning": report.summary,
        "seconds": seconds,
        "euler": source.euler == base.euler,
        "loops": source.border_loops == base.border_loops,
        "components": source.components == base.components,
        "manifold": bool((vertex_fans(lod.F0, opposite_halfedges(lod.F0), len(lod.V0)) == 1).all()),
        "handles": (2 * base.components - base.border_loops - base.euler) // 2,
        "finite": bool(np.isfinite(lod.V).all() and np.isfinite(lod.N).all()),
        "flipped": [flipped(lod.V, lod.N, level.F) for level in levels[1:]],
        "flipped_before": flipped(unit.V, vertex_normals(unit), unit.F),
    }
    if source.border_loops:
        there = border_length(lod.V, finest, levels[-1].opposite)
        row["border"] = there / border_length(unit.V, unit.F, decimation.opposite)
    if task.floor:
        original = Original(unit, 50_000)
        for name, V in (("fitted", lod.V), ("sampled", build_levels(decimation, LEVELS, fitted=False).V)):
            m = original.evaluate(TriMesh(V, finest))
            row[name] = [m.d_pm, m.d_normal, m.d_reverse]
    return row


def causes(row: dict) -> list[str]:
    """Why a row is no valid sequence; empty if it is one."""
    if "error" in row:
        return [row["error"]]
    found = [f"{name} differ" for name in ("euler", "loops", "components") if not row[name]]
    return found + [f"not {name}" for name in ("manifold", "finite") if not row[name]]


def validity(rows: dict[str, dict]) -> list[str]:
    """Lines on all meshes: failures by cause, base sizes, flipped faces, borders."""
    failed = {name: causes(row) for name, row in rows.items() if causes(row)}
    good = [row for name, row in rows.items() if name not in failed]
    reasons = (row["message"].split(": ", 1)[-1].split(" at least ")[0] for row in good if row["base_faces"] > BASE_FACES)
    stopped = Counter(re.sub("[0-9,]+ (?=separate)| [(]holes[^)]*[)]", "", reason) for reason in reasons)
    share = np.array([row["flipped"] for row in good])
    before = np.array([row["flipped_before"] for row in good])
    border = np.array([row["border"] for row in good if "border" in row])
    lines = [
        f"{len(good)} of {len(rows)} meshes give a valid sequence: manifold, Euler characteristic, components and border "
        f"loops of the cleaned input. Base meshes above {BASE_FACES} faces: {sum(stopped.values())} "
        + "(" + "; ".join(f"{count}: {why}" for why, count in stopped.most_common()) + ").",
        "",
        f"Flipped faces at levels 1 to {LEVELS}, mean over meshes: "
        + ", ".join(f"{100 * s:.2f} %" for s in share.mean(0))
        + f"; meshes with more than 0.1 % at level {LEVELS}: {(share[:, -1] > 1e-3).sum()}, of which "
        + f"{(before[share[:, -1] > 1e-3] > 1e-3).sum()} have more than 0.1 % of such faces themselves.",
        "",
        *flipped_by_handles(np.array([row["handles"] for row in good]), share[:, -1]),
        "",
        f"Border length of level {LEVELS} over the input's, {len(border)} open meshes: median {np.median(border):.4f}, "
        f"within 2 % on {100 * np.mean(np.abs(border - 1) < 0.02):.1f} %, least {border.min():.3f}, most {border.max():.3f}.",
    ]
    if failed:
        lines += ["", "| failure | meshes |", "|---|---|"]
        lines += [f"| {why} | {n} |" for why, n in Counter(w for f in failed.values() for w in f).most_common()]
    return lines


def flipped_by_handles(handles: np.ndarray, share: np.ndarray) -> list[str]:
    """Lines of the table of flipped faces at the finest level by the number of handles, which a small base must keep."""
    lines = ["| handles | meshes | flipped, mean % | more than 0.1 % |", "|---|---|---|---|"]
    for least, most in ((0, 0), (1, 4), (5, 19), (20, 39), (40, None)):
        here = (handles >= least) & (handles <= (most if most is not None else handles.max(initial=0)))
        if here.any():
            name = f"{least}" if most == least else (f"{least} to {most}" if most else f"{least} and more")
            count, of = (share[here] > 1e-3).sum(), here.sum()
            lines.append(f"| {name} | {of} | {100 * share[here].mean():.3f} | {count} ({100 * count / of:.0f} %) |")
    return lines


def floor(rows: dict[str, dict]) -> list[str]:
    """Lines of the table on the error of the finest level with nothing lost, geometric means."""
    found = {k: np.array([row[k] for row in rows.values() if k in row]) for k in ("sampled", "fitted")}
    mean = {k: np.exp(np.log(np.maximum(v, 1e-3)).mean(0)) for k, v in found.items()}
    lines = [f"| M^{LEVELS}, {len(found['fitted'])} meshes | d_pm | d_normal | d_reverse |", "|---|---|---|---|"]
    for name in ("sampled", "fitted"):
        lines.append("| " + " | ".join([name, *(f"{x:.3f}" for x in mean[name])]) + " |")
    return [*lines, "| ratio | " + " | ".join(f"{x:.3f}" for x in mean["fitted"] / mean["sampled"]) + " |"]


def main() -> None:
    """Read the options, measure what is missing, print or write the page."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("corpus", type=Path)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--report", type=Path)
    parser.add_argument("--floor-every", type=int, default=1, metavar="N", help="the floor of every Nth val mesh only")
    o = parser.parse_args()
    every = max(o.floor_every, 1)
    tasks = [
        Task(f"{s}/{e.name}", e, s == "val" and k % every == 0) for s in SPLITS for k, e in enumerate(entries(o.corpus, s))
    ]
    rows = pool.run(measure, tasks, Path("out/lod/sequences.jsonl"), o.processes)
    rows = {t.name: rows[t.name] for t in tasks}
    page = [
        "# The LoD builder",
        "",
        f"Made {date.today()} by `python -m benchmarks.lod CORPUS{f' --floor-every {every}' if every > 1 else ''} "
        f"--report docs/lod.md`: {BASE_FACES} base faces, {LEVELS} "
        "levels. d_pm, d_reverse: unit cube x 1e-4; d_normal: degrees.",
        "",
        *validity(rows), "",
        "The floor, geometric means over the val split" + (f", every {every}th mesh in order of size:" if every > 1 else ":"),
        "", *floor(rows), "",
        *table(o.corpus), "",
    ]
    print("\n".join(page))
    if o.report:
        o.report.write_text("\n".join(page))


if __name__ == "__main__":
    main()
