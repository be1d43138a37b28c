"""What the documents point to exists: files, folders, links and the targets of make."""
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
DOCUMENTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
TOPS = ("npm_blender", "core", "tests", "docs", "examples", "training", "benchmarks", "corpus", "extension", "requirements",
        "operators", "panels", "preview", "properties", "jobs", "runtime", "cli", "demo")
MENTION = re.compile(rf"(?<![\w/.<>-])((?:{'|'.join(TOPS)})/[\w/.*{{}},-]*\.(?:py|md|toml|txt|sh|npz|csv|json|png)\b)")
FOLDER = re.compile(r"`((?:npm_blender|tests|docs|examples|training|benchmarks|corpus|extension|requirements)/[\w/-]*)`")
ROOMS = sorted(p.parent.name for p in (ROOT / "npm_blender" / "core").glob("*/__init__.py"))
IN_ROOM = re.compile(rf"(?<![\w/.-])((?:{'|'.join(ROOMS)})/[a-z]\w*)(?:\.py)?\b(?!/)")
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[\w-]+)?\)")


def found(path: str) -> bool:
    """Whether a path, from the folder, the package or the core, is there.

    {a,b} and * stand for several; capitals (ROOM, NAME, NN) for what a reader puts there, so the path before them counts.
    """
    stands_for = re.search(r"/[^/]*\b(?:[A-Z]{2,}(?![a-z])|[a-z_]*_[A-Z]{2,})", path)
    if stands_for and not (ROOT / path).exists():
        path = path[: stands_for.start()]
    if "{" in path:
        head, _, rest = path.partition("{")
        names, _, tail = rest.partition("}")
        return all(found(head + name + tail) for name in names.split(","))
    return any(any(start.glob(path)) if "*" in path else (start / path).exists()
               for start in (ROOT, ROOT / "npm_blender", ROOT / "npm_blender" / "core"))


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda p: p.name)
def test_every_file_that_is_mentioned_exists(document):
    text = document.read_text(encoding="utf-8")
    named = {path for pattern in (MENTION, FOLDER) for path in pattern.findall(text)}
    assert sorted(path for path in named if not found(path)) == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda p: p.name)
def test_every_module_that_is_mentioned_by_its_room_exists(document):
    core = ROOT / "npm_blender" / "core"
    named = IN_ROOM.findall(document.read_text(encoding="utf-8"))
    assert sorted({path for path in named if not (core / f"{path}.py").exists()}) == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda p: p.name)
def test_every_link_leads_somewhere(document):
    links = [link for link in LINK.findall(document.read_text(encoding="utf-8")) if "://" not in link]
    assert [link for link in links if not (document.parent / link).exists()] == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda p: p.name)
def test_every_target_of_make_that_is_named_exists(document):
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    named = set(re.findall(r"(?:^    |`)make ([a-z-]+)", document.read_text(encoding="utf-8"), re.MULTILINE))
    assert named - targets == set()


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda p: p.name)
def test_every_link_to_a_section_of_the_same_page_finds_its_heading(document):
    text = document.read_text(encoding="utf-8")
    headings = {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in re.findall(r"^#+ (.+)$", text, re.MULTILINE)}
    assert set(re.findall(r"\]\(#([\w-]+)\)", text)) - headings == set()


def test_the_tour_names_every_module_of_the_core():
    tour = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    core = ROOT / "npm_blender" / "core"
    modules = [p.relative_to(core).as_posix() for p in sorted(core.rglob("*.py")) if p.name != "__init__.py"]
    assert [name for name in modules if f"`{name}`" not in tour] == []
