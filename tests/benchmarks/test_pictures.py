"""The pictures of the comparison, with stand-ins for the methods. Rendering is in a child process."""
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from benchmarks import pictures
from benchmarks.methods.case import Case, Coded
from corpus.meshes import Entry
from npm_blender.core.errors import SettingsError
from tests.meshes.shapes import icosphere

ROOT = Path(__file__).parents[2]
ENTRIES = [Entry(f"m{i}", Path(f"m{i}.ply"), 100 * i, "") for i in range(9)]

CHILD = """
import sys
from pathlib import Path
from benchmarks import pictures
from benchmarks.methods.case import Case, Coded
from npm_blender.demo import sheet
from tests.meshes.shapes import icosphere

sheet.PIXELS_PER_CELL = 96
found = [("ours", Coded(icosphere(2), 1234, "")), ("nobody's", None), ("other", Coded(icosphere(1), 999, ""))]
pictures.picture(Case("sphere", icosphere(3), 500), found, "y", Path(sys.argv[1]) / "compare_sphere.png")
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where the child wrote its picture."""
    out = tmp_path_factory.mktemp("pictures")
    done = subprocess.run([sys.executable, "-c", CHILD, str(out)], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return out


def test_picture_shows_the_input_and_every_method_that_has_a_result(folder):
    with Image.open(folder / "compare_sphere.png") as image:
        pixels = np.asarray(image.convert("RGB")).astype(float)
    assert pixels.shape[1] == 3 * 96
    drawn = np.abs(pixels - pixels[0, 0]).max(2) > 25
    for cell in np.split(drawn, 3, axis=1):
        upper, caption = cell[: int(0.75 * len(cell))], cell[int(0.8 * len(cell)) :]
        assert 0.2 < upper.mean() < 0.9 and caption.any()


def test_picture_is_written_whole(folder):
    assert [path.name for path in folder.iterdir()] == ["compare_sphere.png"]


def test_large_picture_gets_fewer_colours_until_it_is_small(tmp_path, monkeypatch):
    noise = np.random.default_rng(0).integers(0, 256, (80, 80, 3), np.uint8)
    sizes = []
    for limit in (10**6, 4_500):
        monkeypatch.setattr(pictures, "LARGEST", limit)
        Image.fromarray(noise).save(tmp_path / "noise.png")
        pictures.shrink(tmp_path / "noise.png")
        sizes.append((tmp_path / "noise.png").stat().st_size)
    assert sizes[1] < 4_500 < sizes[0]


def test_meshes_are_named_with_their_axis_or_spread_over_the_sizes():
    named = pictures.chosen(ENTRIES, "m3:y,m0")
    assert [(s.entry.name, s.up) for s in named] == [("m3", "y"), ("m0", "z")]
    spread = [s.entry.faces for s in pictures.chosen(ENTRIES, None)]
    assert len(spread) == 3 and spread[-1] == 800 and spread == sorted(set(spread))
    assert len(pictures.chosen(ENTRIES[:1], None)) == 1


@pytest.mark.parametrize("names", ["m99", "m1:x", "m1,"])
def test_unknown_names_are_one_line(names):
    with pytest.raises(SettingsError, match="NAME:y") as caught:
        pictures.chosen(ENTRIES, names)
    assert "\n" not in str(caught.value)


def test_every_method_gets_the_same_budget():
    asked = []

    def method(name, answer):
        return SimpleNamespace(NAME=name, at_bytes=lambda case, budgets: asked.append(budgets) or [answer])

    coded = Coded(icosphere(1), 12, "")
    found = pictures.results(Case("s", icosphere(1)), 777, [method("a", coded), method("b", None)])
    assert found == [("a", coded), ("b", None)] and asked == [(777,), (777,)]


def test_page_shows_the_pictures_that_there_are(tmp_path):
    page, images = tmp_path / "results.md", tmp_path / "images"
    assert pictures.section(page, images) == []
    images.mkdir()
    for name in ("compare_b.png", "compare_a.png", "other.png"):
        (images / name).write_bytes(b"")
    shown = [line for line in pictures.section(page, images) if line.startswith("![")]
    assert [line.split("(")[-1] for line in shown] == ["images/compare_a.png)", "images/compare_b.png)"]
