"""Seconds and memory of our operations beside their peers', in one run: `python -m benchmarks.speed [--json FILE]`.

The meshes are tori with waves of 100,172 and 1,000,000 faces, made here. Every repeat runs all operations in turn;
medians, and the ratio to the peer (see `operations`). Seconds are the processor's, of one thread: what one waits on an
idle machine, whatever else runs on this one; the start of a process and of its libraries is not among them. Memory is
the peak of a fresh process that does the one thing once; with it goes what that process held before, mostly libraries.
"""

import argparse
import json
import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from corpus.pool import THREADS

from .operations import GROUPS, Inputs, operations, pairs

ROOT = Path(__file__).parent.parent
COMMAND = "python -m benchmarks.speed"
SMALL, LARGE = (317, 158), (1000, 500)  # rows and columns of the tori
REPEATS = 7


def measure(
    repeats: int = REPEATS,
    small: tuple[int, int] = SMALL,
    large: tuple[int, int] = LARGE,
    slow: bool = True,
    groups: tuple[str, ...] = (),
) -> dict:
    """All figures, measured in processes of their own with one thread: what the report shows as its table 5.

    repeats: of every operation but the slow ones; small, large: rows and columns of the tori; slow: whether to measure
    what takes long; groups: of `operations.GROUPS`, all if none is named.

    Returns plain data for JSON: machine (processor, cores, python, load); facts: of the inputs (see `operations.Inputs`);
    operations: by name {seconds (the processor's), bytes (None for a mesh), first_seconds, start_mb, peak_mb (first call
    in a fresh process)}; rows: a list of {group, title, who, ours, peer, ratio}; stages: seconds of our encoder by stage;
    forward: seconds of {backend: {encode, decode}}, the paper's network alone; paper: the same of the publication. `table`
    makes Markdown of it. Raises RuntimeError if a process fails.
    """
    asked = {"repeats": repeats, "small": small, "large": large, "slow": slow, "groups": groups}
    return _child("--measure", json.dumps(asked))


def table(figures: dict) -> list[str]:
    """Lines of Markdown: the command, ratios of ours to peers side by side, stages, forward passes."""
    machine, facts, paper = figures["machine"], figures["facts"], figures["paper"]
    out = [
        f"`{COMMAND}`: seconds of the processor, one thread, medians; {machine['processor']}, one of {machine['cores']} cores, "
        f"load {machine['load']:.1f}. Memory: the peak of a fresh process, in brackets libraries and input.",
        "",
        "| operation | ours, ms | peer | peer, ms | ratio | memory, MB | peer's |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in figures["rows"]:
        ours, peer = (figures["operations"][row[side]] for side in ("ours", "peer"))
        ratio = f"{row['ratio']:.{2 if row['ratio'] >= 0.1 else 4}f}"
        cells = [row["title"], _milliseconds(ours), row["who"], _milliseconds(peer), ratio, _memory(ours), _memory(peer)]
        out.append(f"| {' | '.join(cells)} |")
    stages = ", ".join(f"{k} {1000 * v:,.0f}" for k, v in figures["stages"].items())
    forward = "; ".join(
        f"{name}: encode {1000 * s['encode']:.0f}, decode {1000 * s['decode']:.0f}" for name, s in figures["forward"].items()
    )
    return [
        *out,
        "",
        f"Compressing {facts['small']:,} faces by stage, ms: {stages}. Forward passes of the paper's network alone, ms: "
        f"{forward} (paper, CPU: {1000 * paper['encode']:,.0f} and {1000 * paper['decode']:,.0f}).",
    ]


def _milliseconds(figures: dict) -> str:
    size = "" if figures["bytes"] is None else f" ({figures['bytes']:,} bytes)"
    return f"{1000 * figures['seconds']:,.{0 if figures['seconds'] >= 0.1 else 2}f}{size}"


def _memory(figures: dict) -> str:
    return f"{figures['peak_mb']:,.0f} ({figures['start_mb']:,.0f})"


def medians(calls: dict[str, Callable], repeats: int) -> dict[str, float]:
    """Median seconds of each call, after one that warms up; all calls in turn, `repeats` times."""
    for call in calls.values():
        call()
    seconds = {name: [] for name in calls}
    for _ in range(repeats):
        for name, call in calls.items():
            seconds[name].append(_timed(call))
    return {name: statistics.median(found) for name, found in seconds.items()}


def _timed(call: Callable) -> float:
    begun = time.process_time()
    call()
    return time.process_time() - begun


def _peak_mb() -> float:
    """Peak memory of this process so far. Linux counts what the starting process held in ru_maxrss, so not that there."""
    status = Path("/proc/self/status")
    if status.is_file():
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        return int(line.split()[1]) / 1024
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2**20 if sys.platform == "darwin" else 2**10)


def _processor() -> str:
    """The processor's name."""
    found = Path("/proc/cpuinfo")
    lines = found.read_text().splitlines() if found.is_file() else []
    names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def _child(*arguments: str) -> dict:
    """What `python -m benchmarks.speed` with these arguments prints, as JSON, in a fresh process with one thread."""
    environment = os.environ | dict.fromkeys(THREADS, "1")
    command = [sys.executable, "-m", "benchmarks.speed", *arguments]
    done = subprocess.run(command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        raise RuntimeError(f"Expected {' '.join(arguments)} to be measured, found exit code {done.returncode}")
    return json.loads(done.stdout.splitlines()[-1])


def _all(repeats: int, small: list[int], large: list[int], slow: bool, groups: list[str]) -> dict:
    """The figures of `measure`, in this process but for the memory."""
    from tests.meshes.shapes import torus

    from .forward import PAPER, passes

    mesh, todo = torus(*small), pairs(tuple(groups), slow)
    with tempfile.TemporaryDirectory() as folder:
        inputs = Inputs.write(Path(folder), mesh, torus(*large))
        found = _measured(inputs, {name for pair in todo for name in (pair.ours, pair.peer)}, repeats)
        forward = medians(passes(inputs.bytes_of("paper.npmesh")), repeats)
    rows = []
    for pair in todo:
        about = {"title": pair.title.format(**inputs.facts), "who": pair.who.format(**inputs.facts)}
        ratio = found[pair.ours]["seconds"] / found[pair.peer]["seconds"]
        rows.append({"group": pair.group, "ours": pair.ours, "peer": pair.peer, "ratio": ratio} | about)
    about = {"processor": _processor(), "cores": os.cpu_count()}
    return {
        "machine": about | {"python": platform.python_version(), "load": os.getloadavg()[0]},
        "facts": inputs.facts,
        "operations": found,
        "rows": rows,
        "stages": _stages(mesh),
        "forward": {name: {what: s for (n, what), s in forward.items() if n == name} for name, _ in forward},
        "paper": PAPER,
    }


def _measured(inputs: Inputs, names: set[str], repeats: int) -> dict[str, dict]:
    """The figures of operations, by name."""
    todo = [o for o in operations() if o.name in names]
    calls = {o.name: o.prepare(inputs) for o in todo}
    seconds = medians({o.name: calls[o.name] for o in todo if not o.slow}, repeats)
    seconds |= {o.name: _timed(calls[o.name]) for o in todo if o.slow}
    return {name: {"seconds": seconds[name]} | _child("--once", name, str(inputs.folder)) for name in calls}


def _stages(mesh) -> dict[str, float]:
    """Processor seconds of our encoder by stage: the processor's share of what each stage waited."""
    from npm_blender.core.codec import compress

    begun = time.process_time()
    waited = compress(mesh).report.seconds
    share = (time.process_time() - begun) / sum(waited.values())
    return {stage: share * seconds for stage, seconds in waited.items()}


def _once(name: str, folder: str) -> dict:
    """One operation, in this process, which is a fresh one: bytes it made, seconds of the first call, memory."""
    call = next(o for o in operations() if o.name == name).prepare(Inputs.read(Path(folder)))
    start = _peak_mb()
    begun = time.process_time()
    made = call()
    first = time.process_time() - begun
    size = len(made) if isinstance(made, bytes) else None
    return {"bytes": size, "first_seconds": first, "start_mb": start, "peak_mb": _peak_mb()}


def main() -> None:
    """Measure and print the table; or, for the processes that this starts, one line of JSON."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--repeats", type=int, default=REPEATS)
    parser.add_argument("--groups", default="", help=f"comma-separated, of {', '.join(GROUPS)} (default: all)")
    parser.add_argument("--json", type=Path, help="write the figures here as well")
    parser.add_argument("--measure", type=json.loads, help=argparse.SUPPRESS)
    parser.add_argument("--once", nargs=2, metavar=("NAME", "FOLDER"), help=argparse.SUPPRESS)
    o = parser.parse_args()
    if o.measure:
        print(json.dumps(_all(**o.measure)))
    elif o.once:
        print(json.dumps(_once(*o.once)))
    else:
        groups = tuple(filter(None, o.groups.split(",")))
        unknown = sorted(set(groups) - set(GROUPS))
        if unknown:
            parser.error(f"Expected groups among {', '.join(GROUPS)}, found {', '.join(unknown)}")
        figures = measure(o.repeats, groups=groups)
        if o.json:
            o.json.write_text(json.dumps(figures, indent=1))
        print("\n".join(table(figures)))


if __name__ == "__main__":
    main()
