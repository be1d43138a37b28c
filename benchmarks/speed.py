"""Seconds and memory of our operations beside their peers', in one run: `python -m benchmarks.speed [--json FILE]`.

The mesh is a bumpy sphere of 81,920 faces made here; our stream has 400 base faces and three levels. Every repeat runs
all operations in turn; medians, and the ratio to the peer of the same group (see `operations`). Seconds are the
processor's, of one thread: what one waits on an idle machine, whatever else runs on this one. Memory is the peak of a
fresh process that does the one thing once; with it goes what that process held before, which is mostly the libraries.
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

from .operations import GROUPS, Inputs, operations

ROOT = Path(__file__).parent.parent
DEPTH = 6  # of the bumpy sphere
PAPER = {"encode": 7.42, "decode": 6.93}  # seconds of its forward passes on a CPU (section 4.6)


def measure(repeats: int = 7, depth: int = DEPTH, slow: bool = True, groups: tuple[str, ...] = ()) -> dict:
    """All figures, measured in processes of their own with one thread: what the report shows as its table 5.

    repeats: of every operation but the slow ones; depth: of the bumpy sphere; slow: whether to run those that take long;
    groups: of `operations.GROUPS`, all if none is named.

    Returns plain data for JSON: machine (processor, cores, python, load); faces, stream_bytes, finest_faces: of the
    input, of our stream, of its finest level; rows: a list of {group, method, peer (bool), seconds (the processor's), ratio
    (to the seconds of the group's peer), bytes (None for a mesh), first_seconds, start_mb, peak_mb (first call in a fresh
    process)}; stages: seconds of our encoder by stage, not refined; forward: seconds of {backend: {encode, decode}}, the
    network alone; paper: the same of the publication. `table` makes Markdown of it. Raises RuntimeError if a process fails.
    """
    return _child("--measure", str(repeats), str(depth), str(int(slow)), ",".join(groups))


def table(figures: dict) -> list[str]:
    """Lines of Markdown: operations beside their peers, stages, forward passes."""
    lines = ["| operation | method | ms | ratio to peer | first call, ms | peak, MB | of it libraries and input, MB |",
             "|---|---|---|---|---|---|---|"]
    for row in figures["rows"]:
        ratio = "peer" if row["peer"] else f"{row['ratio']:.{2 if row['ratio'] >= 0.1 else 4}f}"
        size = "" if row["bytes"] is None else f" ({row['bytes']:,} bytes)"
        lines.append(
            f"| {GROUPS[row['group']]} | {row['method']}{size} | {1000 * row['seconds']:,.2f} | {ratio} | "
            f"{1000 * row['first_seconds']:,.0f} | {row['peak_mb']:,.0f} | {row['start_mb']:,.0f} |"
        )
    stages = ", ".join(f"{k} {1000 * v:,.0f}" for k, v in figures["stages"].items())
    forward = "; ".join(
        f"{name}: encode {1000 * s['encode']:.0f}, decode {1000 * s['decode']:.0f}" for name, s in figures["forward"].items()
    )
    machine, paper = figures["machine"], figures["paper"]
    return [
        *lines,
        "",
        f"Input of {figures['faces']:,} faces; stream of {figures['stream_bytes']:,} bytes, finest level "
        f"{figures['finest_faces']:,} faces. {machine['processor']}, one of {machine['cores']} cores, load "
        f"{machine['load']:.1f}. Encoding by stage, not refined, ms: {stages}. Forward passes alone, ms: {forward} (paper, "
        f"CPU: {1000 * paper['encode']:,.0f} and {1000 * paper['decode']:,.0f}).",
    ]


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


def _all(repeats: int, depth: int, slow: bool, groups: list[str]) -> dict:
    """The figures of `measure`, in this process but for the memory."""
    import torch

    from npm_blender.core.mesh import TriMesh, UnitFrame
    from tests.meshes.shapes import bumpy

    torch.set_num_threads(1)
    mesh = bumpy(depth)
    mesh = TriMesh(UnitFrame.of(mesh.V).to_unit(mesh.V), mesh.F)
    with tempfile.TemporaryDirectory() as folder:
        inputs = Inputs.write(Path(folder), mesh)
        todo = [o for o in operations() if (slow or not o.slow) and (not groups or o.group in groups)]
        calls = {o.name: o.prepare(inputs) for o in todo}
        seconds = medians({o.name: calls[o.name] for o in todo if not o.slow}, repeats)
        seconds |= {o.name: _timed(calls[o.name]) for o in todo if o.slow}
        rows = []
        for o in todo:
            peer = next(p for p in todo if p.group == o.group and p.peer)
            fresh = _child("--once", o.name, folder)
            times = {"seconds": seconds[o.name], "ratio": seconds[o.name] / seconds[peer.name]}
            rows.append({"group": o.group, "method": o.method, "peer": o.peer} | times | fresh)
    stages = [_stages(mesh) for _ in range(min(repeats, 3))]
    about = {"processor": _processor(), "cores": os.cpu_count()}
    return {
        "machine": about | {"python": platform.python_version(), "load": os.getloadavg()[0]},
        "faces": len(mesh.F),
        "stream_bytes": len(inputs.ours),
        "finest_faces": inputs.faces[1],
        "rows": rows,
        "stages": {k: statistics.median(s[k] for s in stages) for k in stages[0]},
        "forward": _forward(inputs.ours, repeats),
        "paper": PAPER,
    }


def _stages(mesh) -> dict[str, float]:
    """Processor seconds of our encoder by stage, not refined: the processor's share of what each stage waited."""
    from npm_blender.core.codec import compress
    from npm_blender.core.settings import CompressSettings

    begun = time.process_time()
    waited = compress(mesh, CompressSettings(refine_steps=0)).report.seconds
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


def _forward(data: bytes, repeats: int) -> dict[str, dict[str, float]]:
    """Seconds of the network's forward passes, NumPy and torch."""
    import torch

    from npm_blender.core.bitstream import read_stream
    from npm_blender.core.codec import ProgressiveMesh
    from npm_blender.core.mesh import hierarchy
    from npm_blender.core.network import NUMPY, MeshIndex, TorchBackend, decode, encode, load_weights, map_tree

    stream = read_stream(data)
    progressive = ProgressiveMesh(stream, len(data))
    levels = hierarchy(stream.F0, len(stream.V0), progressive.levels)
    params = load_weights().params
    positions = [progressive.decode_positions(None, i).astype("float32") for i in range(progressive.levels + 1)]
    calls = {}
    for B, tree in ((NUMPY, params), (TorchBackend(), map_tree(torch.from_numpy, params))):
        meshes, V = [MeshIndex.of(B, level) for level in levels], [B.array(v) for v in positions]
        with torch.no_grad():
            f = encode(B, tree, V, meshes)
        calls[B.name, "encode"] = torch.no_grad()(lambda b=B, t=tree, v=V, m=meshes: encode(b, t, v, m))
        calls[B.name, "decode"] = torch.no_grad()(lambda b=B, t=tree, v=V, m=meshes, f=f: decode(b, t, v[0], f, m[:-1]))
    out: dict[str, dict[str, float]] = {}
    for (backend, what), seconds in medians(calls, repeats).items():
        out.setdefault(backend, {})[what] = seconds
    return out


def main() -> None:
    """Measure and print the table; or, for the processes that this starts, one line of JSON."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--json", type=Path, help="write the figures here as well")
    parser.add_argument("--measure", nargs=4, metavar=("REPEATS", "DEPTH", "SLOW", "GROUPS"), help=argparse.SUPPRESS)
    parser.add_argument("--once", nargs=2, metavar=("NAME", "FOLDER"), help=argparse.SUPPRESS)
    o = parser.parse_args()
    if o.measure:
        *numbers, groups = o.measure
        repeats, depth, slow = map(int, numbers)
        print(json.dumps(_all(repeats, depth, bool(slow), groups.split(",") if groups else [])))
    elif o.once:
        print(json.dumps(_once(*o.once)))
    else:
        figures = measure(o.repeats)
        if o.json:
            o.json.write_text(json.dumps(figures, indent=1))
        print("\n".join(table(figures)))


if __name__ == "__main__":
    main()
