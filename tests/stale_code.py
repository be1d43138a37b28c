"""Removes compiled code that calls what has changed since: numba looks at a function's own file only.

Tests do so by themselves; `python -m tests.stale_code` does it before anything else runs, and names the sources.
"""
import ast
import hashlib
import json
import sys
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
RECORD = ROOT / "cache" / "compiled_sources.json"  # of each file: hash of what its compiled code may hold


@cache
def _file_of(module: str) -> Path | None:
    """The file of a module of ours, by its dotted name; None for all else."""
    path = ROOT.joinpath(*module.split("."))
    return next((p for p in (path.with_suffix(".py"), path / "__init__.py") if p.is_file()), None)


@cache
def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def _imports(path: Path) -> frozenset[Path]:
    """The files of ours that a file imports from, wherever in it, of a package its `__init__`."""
    package, found = path.relative_to(ROOT).parent.parts, set()
    for node in ast.walk(_tree(path)):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[:len(package) + 1 - node.level] if node.level else ()
            base = ".".join((*above, *filter(None, [node.module])))
            found.add(base)
            found.update(f"{base}.{alias.name}" for alias in node.names)
    return frozenset(p for p in map(_file_of, found) if p)


def _hash_of(path: Path) -> str:
    """A hash of a file and of all that it imports, directly or not."""
    seen, todo = {path}, [path]
    while todo:
        new = _imports(todo.pop()) - seen
        seen |= new
        todo += new
    return hashlib.sha256(b"".join(sorted(map(_digest, seen)))).hexdigest()


@cache
def _digest(path: Path) -> bytes:
    """A hash of what a file says to the compiler: comments and docstrings do not count."""
    tree = _tree(path)
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node, clean=False) is not None:
            node.body = node.body[1:]
    return hashlib.sha256(ast.dump(tree).encode()).digest()


def remove_stale_code() -> list[str]:
    """Remove it, wherever it lies beside its source; the names of these sources. Without a record all counts as stale."""
    for remembered in (_file_of, _tree, _imports, _digest):
        remembered.cache_clear()
    known = json.loads(RECORD.read_text()) if RECORD.is_file() else {}
    now, stale = {}, []
    for path in sorted(p for folder in ("npm_blender", "benchmarks") for p in (ROOT / folder).rglob("*.py")):
        if "jit import" not in path.read_text(encoding="utf-8"):
            continue
        name = path.relative_to(ROOT).as_posix()
        compiled = list((path.parent / "__pycache__").glob(f"{path.stem}.*.nb[ic]"))
        now[name] = _hash_of(path)
        if compiled and known.get(name) != now[name]:
            stale.append(name)
            for file in compiled:
                file.unlink(missing_ok=True)
    RECORD.parent.mkdir(exist_ok=True)
    RECORD.write_text(json.dumps(now, indent=0))
    return stale


if __name__ == "__main__":
    sys.stdout.writelines(f"{name}\n" for name in remove_stale_code())
