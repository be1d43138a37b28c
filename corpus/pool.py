"""Run a function over meshes in parallel processes, JSON lines as results; a second run does what is missing."""

import json
import os
import sys
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

from npm_blender.core.files import write_file

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
DIED = "the process ended without a result (out of memory, or a crash)"


def done(path: Path, retry: bool = False) -> dict[str, dict]:
    """Results so far, by mesh name, the last one of each; retry: without those that are errors."""
    if not path.is_file():
        return {}
    rows = {}
    for line in path.read_text().splitlines():
        try:
            row = json.loads(line)
        except ValueError:  # the end of a run that was killed while it wrote
            continue
        rows[row["name"]] = row
    return {name: row for name, row in rows.items() if not (retry and "error" in row)}


def drop(path: Path, names: set[str]) -> None:
    """Remove the lines of these meshes, so that the next run makes them anew."""
    if path.is_file():
        kept = [json.dumps(row) + "\n" for name, row in done(path).items() if name not in names]
        write_file(path, "".join(kept).encode())


def append(path: Path, row: dict) -> None:
    """One more line, also after one that was cut short."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a+b") as out:
        if out.tell():
            out.seek(-1, os.SEEK_END)
            if out.read(1) != b"\n":
                out.write(b"\n")
        out.write(json.dumps(row).encode() + b"\n")


def run(function: Callable, tasks: Iterable, path: Path, processes: int = 2) -> dict[str, dict]:
    """function(task) -> dict for every task (with .name) that `path` has no line of; all results by name."""
    results = done(path)

    def keep(task, row: dict) -> str:
        results[task.name] = {"name": task.name, **row}
        append(path, results[task.name])
        return row.get("error", "")

    each(function, [t for t in tasks if t.name not in results], keep, processes)
    return results


def each(function: Callable, tasks: list, keep: Callable[[object, dict], str], processes: int = 2) -> None:
    """function(task) -> dict for every task (with .name) in parallel; keep(task, dict) takes each result as it comes.

    keep returns a remark for the progress line. A task that raises gives {"error": cause}. When a process dies, those
    that ran are tried again alone, so that only the guilty one is reported.
    """
    for name in THREADS:
        os.environ.setdefault(name, "1")
    begun, count, total = time.time(), 0, len(tasks)

    def report(task, row: dict) -> None:
        nonlocal count
        count += 1
        remark = keep(task, row)
        print(f"{count}/{total} {task.name} {time.time() - begun:.0f} s {remark}", file=sys.stderr, flush=True)

    left = tasks
    while left:
        left, suspects = _pass(function, left, report, processes)
        for task in suspects:
            for _ in _pass(function, [task], report, 1)[1]:
                report(task, {"error": DIED})


def _pass(function: Callable, tasks: list, report: Callable, processes: int) -> tuple[list, list]:
    """Run tasks until all are done or a process dies; returns (those not begun, those that ran when it died)."""
    answered: set[int] = set()
    with ProcessPoolExecutor(processes) as pool:
        futures = {pool.submit(function, t): i for i, t in enumerate(tasks)}
        for future in as_completed(futures):
            i = futures[future]
            try:
                row = future.result()
            except BrokenProcessPool:
                break
            except Exception as error:  # one bad mesh must not end the run; its row names the cause
                row = {"error": f"{type(error).__name__}: {error}"}
            answered.add(i)
            report(tasks[i], row)
    open_tasks = [t for i, t in enumerate(tasks) if i not in answered]
    return open_tasks[processes + 1 :], open_tasks[: processes + 1]  # a pool starts them in order
