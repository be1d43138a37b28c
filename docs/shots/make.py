"""Take the pictures of docs/images in a Blender with a window, and make them small.

    .venv/bin/python docs/shots/make.py blender

The last arguments are the command that starts Blender. Without a screen ($DISPLAY), Xvfb is started if there is one.
Exit code 2 where there is no Blender or no screen.
"""
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

from PIL import Image, ImageChops

ROOT = Path(__file__).resolve().parents[2]
SHOTS, IMAGES = ROOT / "out" / "shots", ROOT / "docs" / "images"
MAX_BYTES = 200_000
# file in docs/images: the screenshots that it shows side by side
PICTURES = {
    "panel.png": ("panel",),
    "compress.png": ("before", "during", "after"),
    "budgets.png": ("budget0", "budget1", "budget2"),
    "deviation.png": ("deviation",),
    "lod_set.png": ("lod_set",),
    "batch.png": ("batch",),
}
MAX_WIDTH, MIN_COLOURS = 1280, 32
GAP, PAPER = 8, (255, 255, 255)
FRAME, TABS, MARGIN, FAINT = 6, 0.1, 24, 12  # pixels, share of the width, pixels, levels of grey


def fail(line: str) -> None:
    """Say what is missing and end."""
    print(line, file=sys.stderr)
    raise SystemExit(2)


def screen() -> subprocess.Popen | None:
    """A virtual screen, if there is none and one is needed."""
    if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY") or sys.platform in ("win32", "darwin"):
        return None
    if not shutil.which("Xvfb"):
        fail("Expected a screen ($DISPLAY) or Xvfb, found neither; install Xvfb, or run this where there is a screen")
    display = f":{90 + os.getpid() % 900}"
    process = subprocess.Popen(["Xvfb", display, "-screen", "0", "1600x1000x24"], stderr=subprocess.DEVNULL)
    time.sleep(2)
    os.environ["DISPLAY"] = display
    return process


def take(blender: list[str]) -> None:
    """Run Blender; its window fills the screen."""
    command = [*blender, "--factory-startup", "--window-geometry", "0", "0", "1600", "1000", "--python",
               "docs/shots/pictures.py"]
    if subprocess.run(command, cwd=ROOT).returncode:
        raise SystemExit(1)


def compose(names: tuple[str, ...]) -> Image.Image:
    """What is to be kept of the screenshots, side by side."""
    parts = []
    for name in names:
        with Image.open(SHOTS / f"{name}.png") as picture:
            parts.append(picture.convert("RGB").crop(json.loads((SHOTS / f"{name}.json").read_text())))
    if len(parts) > 1:
        parts = trimmed(parts)
    whole = Image.new("RGB", (sum(p.width for p in parts) + GAP * (len(parts) - 1), max(p.height for p in parts)), PAPER)
    x = 0
    for p in parts:
        whole.paste(p, (x, 0))
        x += p.width + GAP
    if whole.width > MAX_WIDTH:
        whole = whole.resize((MAX_WIDTH, whole.height * MAX_WIDTH // whole.width), Image.LANCZOS)
    return whole


def trimmed(parts: list[Image.Image]) -> list[Image.Image]:
    """The parts without what is empty in all of them; the frame of the screen and the sidebar's tabs do not count."""
    width, height = parts[0].size
    inside = (FRAME, FRAME, int((1 - TABS) * width), height - FRAME)
    boxes = []
    for p in parts:
        seen = p.crop(inside)
        empty = Image.new("RGB", seen.size, seen.getpixel((0, seen.height - 1)))
        boxes.append(ImageChops.difference(seen, empty).point(lambda value: 255 * (value > FAINT)).getbbox())
    left, top = (max(min(box[k] for box in boxes) + FRAME - MARGIN, 0) for k in (0, 1))
    right, bottom = (max(box[k] for box in boxes) + FRAME + MARGIN for k in (2, 3))
    if right > inside[2]:  # a panel: as wide as it is, with its tabs
        left, right = 0, width
    return [p.crop((left, top, right, min(bottom, height))) for p in parts]


def shrink(picture: Image.Image, path: Path) -> None:
    """Write a PNG of at most MAX_BYTES: with fewer colours, chosen for it, until it fits."""
    colours = 256
    while True:
        picture.quantize(colours, kmeans=2, dither=Image.Dither.NONE).save(path, optimize=True)
        if path.stat().st_size <= MAX_BYTES or colours <= MIN_COLOURS:
            return
        colours //= 2


def main() -> None:
    """Prepare, take, compose."""
    blender = sys.argv[1:]
    if not blender or not shutil.which(blender[0]):
        fail(f"Expected a Blender with a window, found {blender[0] if blender else 'none'}; name one: "
             "make shots BLENDER=path")
    subprocess.run([sys.executable, ROOT / "docs" / "shots" / "prepare.py"], check=True)
    process = screen()
    try:
        take(blender)
    finally:
        if process is not None:
            process.terminate()
    for name, shots in PICTURES.items():
        shrink(compose(shots), IMAGES / name)
        print(f"docs/images/{name}: {(IMAGES / name).stat().st_size:,} bytes")


if __name__ == "__main__":
    main()
