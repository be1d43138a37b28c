"""No module above the core imports another that imports it in turn, wherever in them the imports stand."""
import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TOPS = ("npm_blender", "benchmarks", "training", "corpus", "examples")


def name_of(path: Path, root: Path) -> str:
    """The dotted name of a module; that of its package for an __init__.py."""
    parts = path.relative_to(root).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def modules_of(root: Path) -> dict[str, Path]:
    """Every module below TOPS but the core's, by name."""
    found = {name_of(path, root): path for top in TOPS for path in sorted((root / top).rglob("*.py"))}
    return {name: path for name, path in found.items() if not f"{name}.".startswith("npm_blender.core.")}


def statements(node: ast.AST) -> Iterator[ast.Import | ast.ImportFrom]:
    """All imports in a tree, without those that only a type checker sees."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
            continue
        if isinstance(child, ast.Import | ast.ImportFrom):
            yield child
        yield from statements(child)


def imports(name: str, path: Path, known: dict[str, Path]) -> set[str]:
    """The modules that a module imports, and the packages that this loads on the way, unless it is in them itself."""
    package = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
    named = set()
    for statement in statements(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(statement, ast.Import):
            named |= {alias.name for alias in statement.names}
            continue
        above = package[:len(package) - statement.level + 1] if statement.level else []
        module = ".".join([*above, *([statement.module] if statement.module else [])])
        for alias in statement.names:
            inside = f"{module}.{alias.name}"
            named.add(inside if inside in known else module)
    loaded = {one.rsplit(".", k)[0] for one in named for k in range(1, one.count(".") + 1)}
    around = {".".join(package[:k + 1]) for k in range(len(package))}
    return (named | loaded - around) & known.keys() - {name}


def circle_in(edges: dict[str, set[str]]) -> list[str]:
    """The modules of one circle, the first one at its end once more; empty if there is none."""
    done: set[str] = set()
    way: list[str] = []

    def follow(name: str) -> list[str]:
        if name in way:
            return [*way[way.index(name):], name]
        if name not in done:
            way.append(name)
            for other in sorted(edges[name]):
                if found := follow(other):
                    return found
            way.pop()
            done.add(name)
        return []

    return next((found for name in edges if (found := follow(name))), [])


def edges_of(root: Path) -> dict[str, set[str]]:
    """Who imports whom."""
    known = modules_of(root)
    return {name: imports(name, path, known) for name, path in known.items()}


def test_no_module_above_the_core_is_in_an_import_circle():
    circle = circle_in(edges_of(ROOT))
    assert not circle, "an import circle: " + " -> ".join(circle)


def test_benchmarks_may_know_training_but_not_the_other_way_round():
    edges = edges_of(ROOT)
    of = lambda top: {name for name in edges if name.partition(".")[0] == top}
    assert not of("benchmarks") & set().union(*(edges[name] for name in of("training")))
    assert not (of("benchmarks") | of("training")) & set().union(*(edges[name] for name in of("corpus")))


@pytest.mark.parametrize("back, circle", [
    ("from . import a", True), ("from .a import x", True), ("import npm_blender.p.a", True),
    ("def f():\n    from npm_blender.p import a", True),
    ("from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from . import a", False), ("import json", False)])
def test_a_circle_is_found_however_it_is_written(tmp_path, back, circle):
    package = tmp_path / "npm_blender" / "p"
    package.mkdir(parents=True)
    for name, text in (("../__init__", ""), ("__init__", "from .a import x"), ("a", "from .b import y\nx = 1"), ("b", back)):
        (package / f"{name}.py").write_text(text)
    found = circle_in(edges_of(tmp_path))
    assert bool(found) == circle and (not circle or {"npm_blender.p.a", "npm_blender.p.b"} <= set(found))
