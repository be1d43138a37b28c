"""The measured rows of a run, ready to be compared: every comparison is over the meshes that both sides have."""

import argparse
import csv
import io
import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from corpus import pool
from npm_blender.core.files import write_file

from . import methods, options

WORSE = "worse"  # the larger of d_pm and d_reverse: what decides
MEASURES = {
    WORSE: "worse way",
    "d_pm": "d_pm",
    "d_reverse": "d_reverse",
    "d_p99": "99th percentile",
    "d_normal": "d_normal",
}
COLUMNS = ("mesh", "method", "table", "at", "bytes", "cr", "features", "mesh_faces", *MEASURES, "d_max")
LEAST = 1e-3  # in the measures' units (1e-4 of the longest side, degrees): what lies below counts as this much
FLOOR = 0.2  # of the worse way likewise: 0.02 mm on a metre, which nobody sees; else nearly exact files decide every mean


@dataclass(frozen=True)
class Results:
    """rows: by method, mesh and (table, at), as `compare` measured them; names: titles of the methods that have rows;
    meshes: all meshes of the run; errors: (method, mesh, cause); about: by method and mesh, the rest of the line."""

    rows: dict[str, dict[str, dict[tuple, dict]]]
    names: dict[str, str]
    meshes: list[str]
    errors: list[tuple[str, str, str]]
    about: dict[str, dict[str, dict]]

    @staticmethod
    def of(lines: dict[str, dict[str, dict]], names: dict[str, str], meshes: list[str]) -> "Results":
        """lines: by method and mesh, what `compare` wrote; names: titles; meshes: those of the run, others are left out."""
        rows, about, errors = {}, {}, []
        for method, found in lines.items():
            mine = {mesh: found[mesh] for mesh in meshes if mesh in found}
            errors += [(method, mesh, line["error"]) for mesh, line in mine.items() if "error" in line]
            good = {mesh: line for mesh, line in mine.items() if "error" not in line}
            if good:
                rows[method] = {mesh: _by_place(line["rows"]) for mesh, line in good.items()}
                about[method] = {mesh: {k: v for k, v in line.items() if k != "rows"} for mesh, line in good.items()}
        return Results(rows, {m: names[m] for m in names if m in rows}, meshes, errors, about)

    def values(self, method: str, table: str, at, key: str = WORSE) -> dict[str, float]:
        """One measure by mesh, of the meshes that have it."""
        found = {mesh: rows.get((table, at)) for mesh, rows in self.rows.get(method, {}).items()}
        return {mesh: row[key] for mesh, row in found.items() if row is not None}

    def only(self, keep: Callable[[dict], bool]) -> "Results":
        """The same without the rows that `save` refuses."""
        rows = {
            method: {mesh: {k: row for k, row in found.items() if keep(row)} for mesh, found in meshes.items()}
            for method, meshes in self.rows.items()
        }
        return replace(self, rows=rows)

    def of_meshes(self, names: set[str]) -> "Results":
        """The same for some of the meshes."""
        return replace(self, meshes=[mesh for mesh in self.meshes if mesh in names])

    def pairs(self, one: str, other: str, table: str, at, key: str = WORSE) -> tuple[list[str], np.ndarray]:
        """Meshes that both methods have there, and their measures (n, 2)."""
        a, b = self.values(one, table, at, key), self.values(other, table, at, key)
        both = [mesh for mesh in self.meshes if mesh in a and mesh in b]
        return both, np.array([(a[m], b[m]) for m in both]).reshape(-1, 2)

    def ratio(
        self, one: str, other: str, table: str, at, key: str = WORSE, least: float | None = None
    ) -> tuple[float, int]:
        """Geometric mean over meshes of a measure of one method over that of the other, and the number of meshes.

        least: what lies below counts as this much on both sides; None: FLOOR for the worse way, LEAST for others.
        """
        both, found = self.pairs(one, other, table, at, key)
        if not both:
            return float("nan"), 0
        logs = np.log(np.maximum(found, _least(key) if least is None else least))
        return float(np.exp((logs[:, 0] - logs[:, 1]).mean())), len(both)

    def wins(self, one: str, other: str, table: str, at, key: str = WORSE) -> tuple[int, int]:
        """On how many meshes one method is better than the other, and worse; equal within a thousandth is neither."""
        _, found = self.pairs(one, other, table, at, key)
        found = np.maximum(found, _least(key))
        return int((found[:, 0] < 0.999 * found[:, 1]).sum()), int((found[:, 0] > 1.001 * found[:, 1]).sum())

    def csv(self) -> str:
        """All rows, one line each."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(COLUMNS)
        for method, meshes in self.rows.items():
            for mesh, rows in meshes.items():
                for row in rows.values():
                    found = {"mesh": mesh, "method": method} | row
                    writer.writerow([_short(found.get(column, "")) for column in COLUMNS])
        return out.getvalue()


def load(o: argparse.Namespace) -> Results:
    """What has been measured of the meshes that the options choose."""
    lines = {m: pool.done(options.lines(o, m)) for m in o.methods}
    names = {}
    for method in o.methods:
        if lines[method]:
            try:
                names[method] = methods.load(method).NAME
            except ImportError:
                names[method] = method
    return Results.of(lines, names, [e.name for e in options.meshes(o)])


def _by_place(rows: list[dict]) -> dict[tuple, dict]:
    """Rows by table and place in it, each with its error the worse way."""
    return {(row["table"], row["at"]): row | {WORSE: max(row["d_pm"], row["d_reverse"])} for row in rows}


def _least(key: str) -> float:
    return FLOOR if key == WORSE else LEAST


def _short(value) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def write_json(path: Path, value: dict) -> None:
    """Plain data as JSON; figures that do not exist as null."""

    def plain(x):
        if isinstance(x, dict):
            return {str(k): plain(v) for k, v in x.items()}
        if isinstance(x, (list, tuple)):
            return [plain(v) for v in x]
        if isinstance(x, float):
            return None if not np.isfinite(x) else float(f"{x:.5g}")
        return x

    write_file(path, json.dumps(plain(value), indent=1).encode())
