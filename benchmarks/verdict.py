"""The verdict: ours against QSlim + Draco at equal bytes, by the error the worse way.

    python -m benchmarks.verdict [CORPUS] [the options of compare]

prints the tables of what `compare` has measured so far, also while it runs; `compare` prints them when it is done, and the
page of results begins with them.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from corpus.meshes import Entry

from . import options
from .methods import REFERENCE
from .methods.case import BUDGETS
from .results import FLOOR, LEAST, Results, load
from .tables import LARGE, MODEL, NONE, OURS, SIZED, kilo, markdown


@dataclass(frozen=True)
class Row:
    """A row of the table. cell(results, budget, least): its text; floored: whether `least`, the floor of errors, matters."""

    title: str
    cell: Callable[[Results, int, float], str]
    floored: bool


def tables(results: Results, entries: list[Entry]) -> list[str]:
    """Lines: what the figures are; for meshes of many faces, then for all, what was measured, and a table with and one
    without the floor."""
    out = [
        "Ours, one stream that is cut, over QSlim + Draco's best file of at most as many bytes; the worse way is the larger "
        "of d_pm and d_reverse (1e-4 of the longest side), below 1 ours is better. A ratio is over the meshes that both have, "
        f"in brackets how many. Errors below {FLOOR} count as {FLOOR} on both sides; what changes without that is in the "
        "second table.",
        "",
    ]
    large = {entry.name for entry in entries if _faces(results, entry) >= LARGE}
    for title, some in ((f"Meshes of at least {LARGE:,} faces", results.of_meshes(large)), ("All meshes", results)):
        out += [f"### {title}", "", measured(some), ""]
        if _both(some):
            out += [*table(some), "", *without_floor(some), ""]
    return out[:-1]


def table(results: Results, least: float = FLOOR) -> list[str]:
    """Every row, by budgets. least: errors below it count as this much, in 1e-4 of the longest side."""
    rows = [[row.title, *(row.cell(results, budget, least) for budget in BUDGETS)] for row in ROWS]
    return markdown([f"errors below {least:g} as {least:g}", *map(kilo, BUDGETS)], rows)


def without_floor(results: Results) -> list[str]:
    """The rows that the floor changes, without it."""
    rows = [[row.title, *(row.cell(results, budget, LEAST) for budget in BUDGETS)] for row in ROWS if row.floored]
    return markdown(["without that floor", *map(kilo, BUDGETS)], rows)


def measured(results: Results) -> str:
    """How many of the meshes each method has, what failed, and the code that measured ours."""
    failed = {method: sum(m == method and mesh in results.meshes for m, mesh, _ in results.errors) for method in COMPARED}
    parts = []
    for method, name in COMPARED.items():
        count = sum(mesh in results.meshes for mesh in results.rows.get(method, ()))
        parts.append(f"{name} {count}" + (f" (failed: {failed[method]})" if failed[method] else ""))
    codes: dict[str, int] = {}
    for mesh, line in results.about.get(OURS, {}).items():
        if mesh in results.meshes:
            codes[line.get("code") or "unknown"] = codes.get(line.get("code") or "unknown", 0) + 1
    code = "; code of ours: " + ", ".join(f"{name} ({count})" for name, count in codes.items()) if codes else ""
    return f"Measured, of {len(results.meshes)} meshes: {', '.join(parts)}{code}."


def _faces(results: Results, entry: Entry) -> int:
    """Faces as the manifest has them, or as they were measured; 0 where neither is known."""
    lines = (found[entry.name] for found in results.about.values() if entry.name in found)
    return entry.faces or max((line.get("faces", 0) for line in lines), default=0)


def _both(results: Results) -> list[str]:
    """The meshes that ours and the reference were measured on, whether they have files of every size or not."""
    ours, peer = (results.rows.get(method, {}) for method in (OURS, REFERENCE))
    return [mesh for mesh in results.meshes if mesh in ours and mesh in peer]


def _ratio(one: str, other: str) -> Callable[[Results, int, float], str]:
    def cell(results: Results, budget: int, least: float) -> str:
        ratio, count = results.ratio(one, other, "bytes", budget, least=least)
        return f"{ratio:.3f} ({count})" if count else NONE

    return cell


def _worst(results: Results, budget: int, least: float) -> str:
    both, found = results.pairs(OURS, REFERENCE, "bytes", budget)
    if not both:
        return NONE
    found = np.maximum(found, least)
    ratio = found[:, 0] / found[:, 1]
    return f"{ratio.max():.2f} {both[int(ratio.argmax())]}"


def _normals(results: Results, budget: int, least: float) -> str:
    both, found = results.pairs(OURS, REFERENCE, "bytes", budget, "d_normal")
    return "{:.2f} / {:.2f}".format(*found.mean(0)) if both else NONE


def _ways(results: Results, budget: int, least: float) -> str:
    """The larger of both distances of ours over the smaller, geometric mean."""
    both, there = results.pairs(OURS, REFERENCE, "bytes", budget, "d_pm")
    if not both:
        return NONE
    back = results.pairs(OURS, REFERENCE, "bytes", budget, "d_reverse")[1]
    logs = np.log(np.maximum(there[:, 0], least)) - np.log(np.maximum(back[:, 0], least))
    return f"{np.exp(np.abs(logs).mean()):.3f}"


def _fill(results: Results, budget: int, least: float) -> str:
    both, found = results.pairs(OURS, REFERENCE, "bytes", budget, "bytes")
    return "{:.1f} % / {:.1f} %".format(*(100 * found.mean(0) / budget)) if both else NONE


def _missing(results: Results, budget: int, least: float) -> str:
    both = _both(results)
    counts = (sum(mesh not in results.values(method, "bytes", budget) for mesh in both) for method in (OURS, REFERENCE))
    return " / ".join(map(str, counts))


COMPARED = {OURS: "ours", SIZED: "ours made for the size", MODEL: "the paper's model", REFERENCE: "QSlim + Draco"}
ROWS = (
    Row("worse way, ours over QSlim + Draco, geometric mean (meshes)", _ratio(OURS, REFERENCE), True),
    Row("the worst mesh", _worst, True),
    Row("d_normal, degrees, mean: ours / QSlim + Draco", _normals, False),
    Row("ours, worse way over better way, geometric mean", _ways, True),
    Row("one stream over made for its size (meshes)", _ratio(OURS, SIZED), True),
    Row("made for its size over QSlim + Draco (meshes)", _ratio(SIZED, REFERENCE), True),
    Row("the paper's model over QSlim + Draco (meshes)", _ratio(MODEL, REFERENCE), True),
    Row("bytes used of the budget, mean: ours / QSlim + Draco", _fill, False),
    Row("meshes without so small a file: ours / QSlim + Draco", _missing, False),
)


def main() -> None:
    """Read the options and print."""
    o = options.parse(__doc__)
    print("\n".join(tables(load(o), options.meshes(o))))


if __name__ == "__main__":
    main()
