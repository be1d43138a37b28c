"""Run a function over meshes in parallel processes, one JSON line per result; a second run does what is missing."""

import json
import os
import sys
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path


def done(path: Path) -> dict[str, dict]:
    """Results so far, by mesh name."""
    if not path.is_file():
        return {}
    return {row["name"]: row for row in map(json.loads, path.read_text().splitlines())}


def run(function: Callable, tasks: Iterable, path: Path, processes: int = 2) -> dict[str, dict]:
    """function(task) -> dict for every task (with .name) that `path` has no line of; all results by name."""
    results = done(path)
    todo = [t for t in tasks if t.name not in results]
    path.parent.mkdir(parents=True, exist_ok=True)
    begun = time.time()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    with ProcessPoolExecutor(processes) as pool, path.open("a") as out:
        futures = {pool.submit(function, t): t for t in todo}
        for i, future in enumerate(as_completed(futures), 1):
            name = futures[future].name
            try:
                row = {"name": name, **future.result()}
            except Exception as error:  # one bad mesh must not end the run; its line names the cause
                row = {"name": name, "error": f"{type(error).__name__}: {error}"}
            results[name] = row
            out.write(json.dumps(row) + "\n")
            out.flush()
            print(
                f"{i}/{len(todo)} {name} {time.time() - begun:.0f} s {row.get('error', '')}",
                file=sys.stderr,
                flush=True,
            )
    return results
