"""The options that the benchmarks share: the meshes that they choose, and where what is measured of them lies."""

import argparse
import subprocess
import sys
from pathlib import Path

import numpy as np

from corpus.meshes import SUFFIXES, Entry, entries
from npm_blender.core.network import load_weights

from .methods import METHODS

QUICK_MESHES, QUICK_SAMPLES = 6, 20_000
QUICK_FACES = (4_000, 20_000)
SLOW = ("ours_sized",)  # make a stream, or several, for every budget: not part of a quick run
MADE = Path("out/bench/meshes")
ROOT = Path(__file__).parents[1]
SEARCHED = "worse"  # by what searches choose; what was measured under another rule is not taken for the same


def parse(doc: str) -> argparse.Namespace:
    """Options of `compare` and `report`; doc: the module's docstring."""
    parser = argparse.ArgumentParser(description=doc.split("\n")[0])
    parser.add_argument("corpus", type=Path, nargs="?", help="folder of meshes, or with manifest.csv; none: Blender makes some")
    parser.add_argument("--split", default="test")
    parser.add_argument("--quick", action="store_true", help=f"{QUICK_MESHES} meshes of moderate size, fewer samples")
    parser.add_argument("--limit", type=int, help="so many meshes, spread over the sizes")
    parser.add_argument("--min-faces", type=int, default=0, help="only meshes of so many faces; needs a manifest.csv")
    parser.add_argument("--samples", type=int, help="points each way (default 50,000; quick 20,000)")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--methods", type=_names, help="comma-separated (default: all; quick: the fast)")
    parser.add_argument("--order", default="gain", help="of the latents of the paper's model")
    parser.add_argument("--tag", default="", help="keep the results apart from those of other settings")
    parser.add_argument("--retry", action="store_true", help="measure again what ended in an error")
    parser.add_argument("--redo", type=_names, default=(), help="measure these methods anew on the chosen meshes")
    parser.add_argument("--no-report", dest="page", action="store_false", help="print the verdict and write no page")
    parser.add_argument("--report", type=Path, help="write the page here, and results/ beside it (default: in out/bench)")
    parser.add_argument("--no-runtime", dest="runtime", action="store_false", help="leave out seconds and memory of operations")
    o = parser.parse_args()
    o.samples = o.samples or (QUICK_SAMPLES if o.quick else 50_000)
    o.methods = o.methods or tuple(m for m in METHODS if not (o.quick and m in SLOW))
    for given, known in ((o.methods, METHODS), (o.redo, o.methods)):
        unknown = sorted(set(given) - set(known))
        if unknown:
            parser.error(f"Expected methods among {', '.join(known)}, found {', '.join(unknown)}")
    if o.corpus and not listed(o.corpus) and not loose(o.corpus):
        parser.error(f"Expected a folder with manifest.csv or with {' '.join(SUFFIXES)} files, found none in {o.corpus}")
    if o.min_faces and o.corpus and not listed(o.corpus):
        parser.error(f"Expected a manifest.csv for --min-faces, found none in {o.corpus}")
    return o


def _names(text: str) -> tuple[str, ...]:
    return tuple(text.split(","))


def listed(folder: Path) -> bool:
    """Whether a folder has a manifest."""
    return (folder / "manifest.csv").is_file()


def loose(folder: Path) -> list[Entry]:
    """The mesh files of a folder without a manifest, the smallest file first; how many faces they have is not known."""
    files = [p for p in folder.glob("*") if p.suffix.lower() in SUFFIXES and p.is_file()]
    return [Entry(p.name, p, 0, "") for p in sorted(files, key=lambda p: (p.stat().st_size, p.name))]


def set_name(o: argparse.Namespace) -> str:
    """A name for the set of meshes: the corpus folder's and the split's, or made."""
    return f"{o.corpus.resolve().name}_{o.split}" if o.corpus else "made"


def meshes(o: argparse.Namespace) -> list[Entry]:
    """The meshes that the options choose, smallest first."""
    if o.corpus:
        found = entries(o.corpus, o.split) if listed(o.corpus) else loose(o.corpus)
    else:
        if not (MADE / "manifest.csv").is_file():
            subprocess.run([sys.executable, "-m", "benchmarks.made", str(MADE)], check=True)
        found = entries(MADE, "test")
    found = [e for e in found if e.faces >= o.min_faces]
    if o.quick and o.corpus:
        low, high = QUICK_FACES
        found = [e for e in found if low <= e.faces <= high] or found
    count = QUICK_MESHES if o.quick else o.limit
    if count and count < len(found):
        found = [found[i] for i in np.linspace(0, len(found) - 1, count).round().astype(int)]
    return found


def code() -> str:
    """The version of the code that measures, as git describes it; "" where git or its folder is not there."""
    command = ["git", "describe", "--always", "--dirty", "--exclude", "*"]
    try:
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def folder(o: argparse.Namespace) -> Path:
    """Where the lines of a run lie: apart for other splits, samples, searches, settings and weights."""
    tag = f"_{o.tag}" if o.tag else ""
    return Path("out/bench") / f"{set_name(o)}_{o.samples}_{SEARCHED}{tag}"


def lines(o: argparse.Namespace, method: str) -> Path:
    """The file of a method's lines; those of the paper's model depend on the weights as well."""
    digest = f"_{load_weights().digest.hex()}" if method == "ours_paper" else ""
    return folder(o) / f"{method}{digest}.jsonl"
