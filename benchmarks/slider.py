"""Drags the slider of a preview through 200 positions in Blender, and switches levels: times, and memory.

    .venv/bin/python -m benchmarks.slider [STREAM.npmesh]                 the bpy module
    blender -b --factory-startup -P benchmarks/slider.py -- [STREAM]      a real Blender, no window
    blender --factory-startup --window-geometry 0 0 320 240 -P benchmarks/slider.py -- [STREAM]      a window, drawn

Without STREAM, the demo's (out/demo/sculpt.npmesh; `make demo`). Without a window, a position counts from setting the
property until the mesh is there and evaluated; in one, until it has been drawn, beside an ordinary mesh that is changed
and drawn in the same way (slider_window.py). Prints one JSON object: medians in milliseconds of the clock; `slow` is what
one move in ten is slower than; `processor` and `own` are processor time (OMP_NUM_THREADS=1: of one thread), which is what
one waits on an idle machine, `own` of the extension alone. Memory is what the process holds after a round there and back,
garbage collected and free memory handed back, from the second round on: the first fills what is kept of recent positions.
"""
import ctypes
import gc
import importlib
import json
import os
import sys
import time
import traceback
from collections.abc import Generator
from pathlib import Path
from statistics import median

import bpy

ROOT = Path(__file__).resolve().parents[1] if "__file__" in globals() else Path.cwd()
sys.path.insert(0, str(ROOT))

from tests.addon.source_addon import enable  # noqa: E402 - found in ROOT

POSITIONS, ROUNDS, SWITCHES = 200, 4, 40
KNOWN = 30  # positions on the way back whose meshes are still kept; a decoder keeps 32
LEVEL = "3"


def memory() -> float:
    """Resident memory of this process without what it could give back, MiB; 0 where the system does not tell."""
    gc.collect()
    try:
        ctypes.CDLL(None).malloc_trim(0)  # glibc's
    except (OSError, AttributeError, TypeError):
        pass
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except OSError:
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def milliseconds(step) -> float:
    """How long `step` takes."""
    start = time.perf_counter()
    step()
    return 1000 * (time.perf_counter() - start)


class Drag:
    """One preview, and what a user does to it."""

    def __init__(self, package: str, path: Path) -> None:
        """Open the stream at `path`."""
        self.updates = importlib.import_module(f"{package}.preview.updates")
        for obj in list(bpy.data.objects):
            bpy.data.objects.remove(obj)
        bpy.ops.import_scene.npmesh(filepath=str(path))
        self.obj = bpy.context.view_layer.objects.active
        self.state = self.obj.npmesh
        self.state.level = str(min(int(LEVEL), self.state.level_count))

    def show(self) -> None:
        """Let the mesh follow, and evaluate it."""
        self.updates.flush()  # what would wait for the timer
        bpy.context.view_layer.update()
        len(self.obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices)

    def move(self, features: int) -> None:
        """One position of the slider."""
        self.state.features = features
        self.show()

    def switch(self, level: int) -> None:
        """Another level."""
        self.state.level = str(level)
        self.show()


def positions(total: int, seed: int) -> list[int]:
    """Features of POSITIONS places of the slider, there and back, other ones for every seed."""
    half = [round(total * ((k + seed / (ROUNDS + 1)) / (POSITIONS // 2)) ** 3) for k in range(POSITIONS // 2)]
    return half + half[::-1]


def run(package: str, path: Path) -> dict:
    """All measures of one stream, without a window."""
    drag = Drag(package, path)
    total, levels = drag.state.total_features, drag.state.level_count
    new, busy, known, used = [], [], [], []
    for seed in range(ROUNDS):
        there = positions(total, seed)
        half = len(there) // 2
        times = []
        for k in there[:half]:
            begun = time.process_time()
            took = milliseconds(lambda k=k: drag.move(k))
            times.append((took, 1000 * (time.process_time() - begun)))
        again = [milliseconds(lambda k=k: drag.move(k)) for k in there[half:half + KNOWN][1:]]
        for k in there[half + KNOWN:]:
            drag.move(k)
        if seed:  # the first round loads and fills what the others find
            new += [wall for wall, _ in times]
            busy += [processor for _, processor in times]
            known += again
            used.append(memory())
    for level in range(levels + 1):
        drag.switch(level)
    switching = [milliseconds(lambda k=k: drag.switch(k % (levels + 1))) for k in range(SWITCHES)]
    return {**described(drag, path), "new_prefix_ms": round(median(new), 1), "new_prefix_slow_ms": slow(new),
            "new_prefix_processor_ms": round(median(busy), 1), "known_prefix_ms": round(median(known), 1),
            "level_switch_ms": round(median(switching), 1), **growth(used)}


def run_in_window(package: str, path: Path) -> Generator[None, None, dict]:
    """All measures of one stream with drawing; yields where Blender goes on."""
    from benchmarks import slider_window as window

    yield from window.make_drawing_cheap()
    drag = Drag(package, path)
    for level in (*range(drag.state.level_count), drag.state.level_count, min(int(LEVEL), drag.state.level_count)):
        drag.switch(level)  # now all meshes are there
    stamp = importlib.import_module(f"{package}.preview").STAMP
    total = drag.state.total_features
    yield from window.measured(drag, [positions(total, 0)], KNOWN, SWITCHES, stamp)
    used, rounds = [], []
    for seed in range(1, ROUNDS):
        rounds.append((yield from window.measured(drag, [positions(total, seed)], KNOWN, SWITCHES, stamp)))
        used.append(memory())
    values = {name: [value for found in rounds for value in found[name]] for name in rounds[0]}
    times = {name: round(median(found), 1) for name, found in values.items()}
    return {**described(drag, path), "new_prefix_ms": times["new"], "new_prefix_slow_ms": slow(values["new"]),
            "new_prefix_own_ms": times["new_own"], "new_prefix_own_slow_ms": slow(values["new_own"]),
            "known_prefix_ms": times["known"], "known_prefix_own_ms": times["known_own"], "plain_mesh_ms": times["plain"],
            "level_switch_ms": times["switch"], "level_switch_own_ms": times["switch_own"],
            "plain_switch_ms": times["plain_switch"], "unchanged_ms": times["redraw"], **growth(used)}


def slow(times: list[float]) -> float:
    """What one in ten is slower than: where a move changes a coarse level, all finer ones are decoded again."""
    return round(sorted(times)[len(times) * 9 // 10], 1)


def described(drag: Drag, path: Path) -> dict:
    """What was measured."""
    return {"blender": bpy.app.version_string, "window": not bpy.app.background, "stream": path.name,
            "faces": drag.state.shown_faces,
            "features": drag.state.total_features}


def growth(used: list[float]) -> dict:
    """Memory in MiB after each round, and by how much of the first it grew."""
    return {"memory_mib": [round(x, 1) for x in used],
            "memory_growth_percent": round(100 * (used[-1] / used[0] - 1), 2) if used[0] else None}


def main() -> None:
    """Measure once; quit Blender if it has a window."""
    given = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:] if not bpy.app.binary_path else []
    path = Path(given[0]) if given else ROOT / "out" / "demo" / "sculpt.npmesh"
    package = enable(ROOT)
    if bpy.app.background:
        print(json.dumps(run(package, path)))
        return
    steps = run_in_window(package, path)

    def tick() -> float | None:
        try:
            next(steps)
            return 0.0
        except StopIteration as end:
            print(json.dumps(end.value), flush=True)
        except BaseException:
            traceback.print_exc()
        bpy.ops.wm.quit_blender()
        return None

    bpy.context.preferences.view.show_splash = False
    bpy.app.timers.register(tick, first_interval=2.0)


if __name__ == "__main__":
    main()
