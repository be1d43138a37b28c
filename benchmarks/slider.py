"""Drags the slider of a preview through 200 positions in Blender, and switches levels: times, and memory.

    .venv/bin/python -m benchmarks.slider [STREAM.npmesh]                 the bpy module
    blender -b --factory-startup -P benchmarks/slider.py -- [STREAM]      a real Blender, no window
    blender --factory-startup -P benchmarks/slider.py -- [STREAM]         a window: drawing is measured too

Without STREAM, the demo's (out/demo/sculpt.npmesh; `make demo`). A position counts from setting the property until the
mesh is there and evaluated. Drawing a changed mesh comes on top; it is measured by itself, on fewer positions, as without
a graphics card it takes longer than everything else. Prints one JSON object: medians in milliseconds of the clock, and
for new prefixes of the processor too, which is what one waits on an idle machine (OMP_NUM_THREADS=1: of one thread).
"""
import importlib
import json
import os
import sys
import time
from pathlib import Path
from statistics import median

import bpy

ROOT = Path(__file__).resolve().parents[1] if "__file__" in globals() else Path.cwd()
sys.path.insert(0, str(ROOT))

from tests.addon.source_addon import enable  # noqa: E402 - found in ROOT

POSITIONS, ROUNDS, SWITCHES, DRAWN = 200, 3, 40, 5
KNOWN = 30  # positions on the way back whose meshes are still kept; a decoder keeps 32
LEVEL = "3"


def memory() -> float:
    """Resident memory of this process, MiB; 0 where the system does not tell."""
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

    def draw(self) -> None:
        """Draw the window."""
        bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)

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
    """All measures of one stream."""
    drag = Drag(package, path)
    total, levels = drag.state.total_features, drag.state.level_count
    for features in positions(total, 0)[:20]:
        drag.move(features)
    new, busy, known, used = [], [], [], []
    for seed in range(1, ROUNDS + 1):
        there = positions(total, seed)
        half = len(there) // 2
        for k in there[:half]:
            begun = time.process_time()
            new.append(milliseconds(lambda k=k: drag.move(k)))
            busy.append(1000 * (time.process_time() - begun))
        used.append(memory())
        known += [milliseconds(lambda k=k: drag.move(k)) for k in there[half:half + KNOWN][1:]]
        for k in there[half + KNOWN:]:
            drag.move(k)
        used.append(memory())
    for level in range(levels + 1):
        drag.switch(level)
    switching = [milliseconds(lambda k=k: drag.switch(k % (levels + 1))) for k in range(SWITCHES)]
    drawing = []
    for features in () if bpy.app.background else positions(total, 0)[::POSITIONS // DRAWN]:
        drag.move(features)
        drawing.append(milliseconds(drag.draw))
    return {"blender": bpy.app.version_string, "window": not bpy.app.background, "stream": path.name,
            "faces": drag.state.stream_base_faces * 4 ** min(int(LEVEL), levels), "features": total,
            "new_prefix_ms": round(median(new), 1), "new_prefix_processor_ms": round(median(busy), 1),
            "known_prefix_ms": round(median(known), 1),
            "level_switch_ms": round(median(switching), 1), "drawing_ms": round(median(drawing), 1) if drawing else None,
            "memory_mib": [round(x, 1) for x in used],
            "memory_growth_percent": round(100 * (used[-1] / used[0] - 1), 2) if used[0] else None}


def main() -> None:
    """Measure once; quit Blender if it has a window."""
    given = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:] if not bpy.app.binary_path else []
    path = Path(given[0]) if given else ROOT / "out" / "demo" / "sculpt.npmesh"
    package = enable(ROOT)
    if bpy.app.background:
        print(json.dumps(run(package, path)))
        return

    def in_window() -> None:
        window = bpy.context.window_manager.windows[0]
        area = next(a for a in window.screen.areas if a.type == "VIEW_3D")
        try:
            with bpy.context.temp_override(window=window, area=area):
                print(json.dumps(run(package, path)), flush=True)
        finally:
            bpy.ops.wm.quit_blender()

    bpy.context.preferences.view.show_splash = False
    bpy.app.timers.register(in_window, first_interval=2.0)


if __name__ == "__main__":
    main()
