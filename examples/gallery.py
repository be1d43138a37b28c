"""Run all examples and make a page of them: python -m examples.gallery [FOLDER], or `make examples`."""
import ast
import contextlib
import html
import io
import runpy
import sys
import time
from pathlib import Path

EXAMPLES = sorted(Path(__file__).parent.glob("[0-9][0-9]_*.py"))
PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>Neural Progressive Meshes: the stages</title>
<style>
body {{ font: 15px/1.5 sans-serif; max-width: 1100px; margin: 2em auto; padding: 0 1em; color: #222 }}
img {{ max-width: 100%; display: block }}
pre {{ background: #f4f5f7; padding: .7em 1em; overflow-x: auto; font-size: 13px }}
</style>
<h1>Neural Progressive Meshes, stage by stage</h1>
{}
</html>
"""


def run(example: Path, out: Path) -> str:
    """What an example prints; it writes into `out`."""
    said, before = io.StringIO(), sys.argv
    sys.argv = [str(example), str(out)]
    try:
        with contextlib.redirect_stdout(said):
            runpy.run_path(str(example), run_name="__main__")
    except SystemExit as end:
        if end.code:
            raise
    finally:
        sys.argv = before
    return said.getvalue()


def section(example: Path, said: str, out: Path) -> str:
    """The part of the page about one example: what it shows, its pictures, what it prints, and its text."""
    source = example.read_text(encoding="utf-8")
    first, _, more = ast.get_docstring(ast.parse(source)).partition("\n\n")
    pictures = "".join(f'<img src="{p.name}" alt="{p.stem}">' for p in sorted(out.glob(f"{example.stem[:2]}_*.png")))
    return (f"<h2>{example.stem.replace('_', ' ')}</h2>\n<p><b>{html.escape(first)}</b></p>\n<p>{html.escape(more)}</p>\n"
            f"{pictures}\n"
            f"<pre>{html.escape(said)}</pre>\n<details><summary>examples/{example.name}</summary>"
            f"<pre>{html.escape(source)}</pre></details>\n")


def gallery(out: Path) -> Path:
    """Run all examples in this process; the page that shows them."""
    out.mkdir(parents=True, exist_ok=True)
    sections = []
    for example in EXAMPLES:
        start = time.perf_counter()
        said = run(example, out)
        print(f"{example.stem}: {time.perf_counter() - start:.1f} s")
        sections.append(section(example, said, out))
    page = out / "index.html"
    page.write_text(PAGE.format("\n".join(sections)), encoding="utf-8")
    return page


if __name__ == "__main__":
    print(gallery(Path(sys.argv[1] if len(sys.argv) > 1 else "out/examples")))
