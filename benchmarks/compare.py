"""All methods on a folder of meshes: the paper's tables, and errors at equal bytes.

    python -m benchmarks.compare [CORPUS] [--split test] [--quick] [--limit N] [--min-faces N]
                                 [--methods ours,qslim_draco] [--redo ours] [--no-report]

Without a corpus the meshes are made by Blender (see `made`). Each mesh is measured in a process of its own, one JSON
line per mesh and method in out/bench; a second run does what is missing. After a change of ours, --redo ours measures
ours again and leaves the peers' lines as they are; a run that was stopped goes on without --redo. At its end this prints
the tables of `python -m benchmarks.verdict`, and calls `python -m benchmarks.report`, which writes the whole page.
"""

import time
from dataclasses import dataclass

from corpus import pool
from corpus.meshes import Entry
from npm_blender.core.evaluation import Metrics
from npm_blender.core.settings import CompressSettings

from . import methods, options, verdict
from .methods.case import BUDGETS, CURVE, FEATURES, Case
from .results import load


@dataclass(frozen=True)
class Task:
    """One mesh and the methods that are missing."""

    name: str
    entry: Entry
    methods: tuple[str, ...]
    samples: int
    settings: CompressSettings


def measure(task: Task) -> dict[str, dict]:
    """Row of each method; a method that fails has the cause in its row."""
    case = Case.of(task.name, task.entry.read(), task.samples, task.settings)
    case.original  # noqa: B018  made here, so that no method pays for it
    case.base_vertices  # noqa: B018
    out = {}
    for name in task.methods:
        begun = time.process_time()
        try:
            rows = method_rows(case, name)
            out[name] = {"rows": rows, "seconds": time.process_time() - begun, "stages": case.seconds.copy()}
        except Exception as error:  # the row names the cause; the other methods go on
            out[name] = {"error": f"{type(error).__name__}: {error}"}
        case.seconds.clear()
        out[name] |= {"faces": len(case.mesh.F), "vertices": len(case.mesh.V)}
    return out


def method_rows(case: Case, name: str) -> list[dict]:
    """All that a method can do, measured: rows with `table` (bytes, scalars, or what its extra names) and `at`."""
    method = methods.load(name)
    rows, seen = [], {}
    if hasattr(method, "at_bytes"):
        for budget, coded in zip(BUDGETS, method.at_bytes(case, BUDGETS), strict=True):
            if coded is None:
                continue
            setting = (coded.bytes, coded.label)
            if setting not in seen:  # a mesh that fits whole is the same for every larger budget
                seen[setting] = figures(case, coded.mesh)
            rows.append({"table": "bytes", "at": budget, "bytes": coded.bytes, "label": coded.label} | seen[setting])
    if hasattr(method, "at_scalars"):
        points = [k for k in CURVE if k in FEATURES or case.cr(case.scalars(k)) > 1]
        counts = [case.scalars(k) for k in points]
        for k, count, mesh in zip(points, counts, method.at_scalars(case, counts), strict=True):
            if mesh is not None:
                about = {"table": "scalars", "at": k, "scalars": count, "cr": case.cr(count)}
                rows.append(about | figures(case, mesh))
    for about, mesh in getattr(method, "extra", lambda _: [])(case):
        rows.append(about | figures(case, mesh))
    return rows


def figures(case: Case, mesh) -> dict:
    """Faces and errors of a decoded mesh."""
    m: Metrics = case.original.evaluate(mesh)
    return {"mesh_faces": len(mesh.F)} | {k: round(v, 5) for k, v in vars(m).items()}


def main() -> None:
    """Read the options, measure what is missing, print the verdict, write the report."""
    o = options.parse(__doc__)
    found, code = options.meshes(o), options.code()
    for m in o.redo:
        pool.drop(options.lines(o, m), {entry.name for entry in found})
    settings = CompressSettings(order=o.order)
    have = {m: pool.done(options.lines(o, m), o.retry) for m in o.methods}
    tasks = []
    for entry in found:
        missing = tuple(m for m in o.methods if entry.name not in have[m])
        if missing:
            tasks.append(Task(entry.name, entry, missing, o.samples, settings))

    def keep(task: Task, rows: dict) -> str:
        if "error" in rows:
            rows = {m: rows for m in task.methods}
        for m, row in rows.items():
            pool.append(options.lines(o, m), {"name": task.name, "code": code, **row})
        return "; ".join(f"{m}: {row['error']}" for m, row in rows.items() if "error" in row)

    pool.each(measure, tasks, keep, o.processes)
    print("\n".join(verdict.tables(load(o), found)))
    if o.page:
        from . import report  # which loads matplotlib; measuring does without

        print(report.write(o))


if __name__ == "__main__":
    main()
