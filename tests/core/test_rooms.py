"""The rooms of the core: what each may import, what it exports, and that the examples of what it exports are true."""
import ast
import doctest
import importlib
import inspect
from pathlib import Path

import pytest

CORE = Path(__file__).parents[2] / "npm_blender" / "core"
FILES = [p for p in sorted(CORE.rglob("*.py")) if p != CORE / "__init__.py"]
GROUND = {"errors", "progress", "jit", "files", "settings", "parallel", "lazy"}
WITH_EXAMPLES = {"settings", "parallel", "progress", "lazy"}  # of the ground; the others may have some
MAY_IMPORT = {
    "errors": set(), "progress": set(), "jit": set(), "lazy": set(),
    "files": {"errors"}, "settings": {"errors"}, "parallel": {"progress"},
    "mesh": {"errors"},  # never jit: it must load without numba
    "geometry": {"mesh"} | GROUND,
    "parameterization": {"mesh", "geometry"} | GROUND,
    "displacement": {"mesh"},  # never jit: Blender's window decodes with it
    "network": {"mesh", "errors", "lazy"},  # never jit; torch in torch_backend only
    "bitstream": {"mesh", "jit", "errors", "lazy"},  # from jit only njit: a test below
    "meshio": {"mesh", "geometry"} | GROUND,
    "cleaning": {"mesh", "geometry"} | GROUND,
    "untangling": {"mesh", "geometry"} | GROUND,
    "decimation": {"mesh", "geometry", "parameterization"} | GROUND,
    "levels": {"mesh", "geometry", "parameterization", "decimation", "untangling"} | GROUND,
    "fitting": {"mesh", "geometry", "displacement"} | GROUND,
    "codec": {"mesh", "geometry", "cleaning", "decimation", "levels", "network", "bitstream", "displacement",
              "fitting"} | GROUND,
    "evaluation": {"mesh", "geometry", "codec"} | GROUND,
}
ROOMS = sorted(p.parent.name for p in CORE.glob("*/__init__.py"))


def imports(path: Path) -> list[tuple[str, str, list[str]]]:
    """(room or ground file of core, what of it, names) of each relative import in a file, wherever it stands."""
    inside, found = path.relative_to(CORE), []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level == len(inside.parts):
            names = [alias.name for alias in node.names]
            room, _, rest = (node.module or "").partition(".")
            found += [(room, rest, names)] if room else [(name, "", []) for name in names]
    return found


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(CORE)))
def test_a_room_imports_only_what_stands_below_it(path):
    room = path.relative_to(CORE).parts[0].removesuffix(".py")
    assert {used for used, _, _ in imports(path)} <= MAY_IMPORT[room]


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(CORE)))
def test_what_a_room_needs_of_another_it_takes_at_its_door(path):
    assert [(room, rest) for room, rest, _ in imports(path) if rest] == []


def test_the_stream_is_coded_by_functions_that_need_no_numba():
    for path in (CORE / "bitstream").glob("*.py"):
        assert all(names == ["njit"] for room, _, names in imports(path) if room == "jit"), path


@pytest.mark.parametrize("package", ["npm_blender.core", *(f"npm_blender.core.{room}" for room in ROOMS)])
def test_a_door_exports_what_it_says(package):
    module = importlib.import_module(package)
    assert module.__all__ == sorted(set(module.__all__))
    for name in module.__all__:
        assert getattr(module, name) is not None
    assert set(module.__all__) <= set(dir(module))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = module.nothing


@pytest.mark.parametrize("package", ["npm_blender.core", *(f"npm_blender.core.{room}" for room in ROOMS)])
def test_what_a_type_checker_sees_of_a_door_is_what_it_exports(package):
    path = Path(importlib.import_module(package).__file__)
    seen = {(node.module, alias.name) for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            if isinstance(node, ast.ImportFrom) and node.level == 1 and node.module != "lazy" for alias in node.names}
    assert sorted(name for _, name in seen) == importlib.import_module(package).__all__
    for module, name in seen:
        assert getattr(importlib.import_module(f"{package}.{module}"), name) is getattr(importlib.import_module(package), name)


def exported() -> list[tuple[str, str]]:
    """(room, name) of every function and class that a room exports: all but constants, without loading any of them."""
    return [(room, name) for room in ROOMS for name in importlib.import_module(f"npm_blender.core.{room}").__all__
            if not name.isupper()]


def run_examples(value: object, name: str) -> int:
    """Run the examples in the docstring of a function or class; how many lines of examples there were."""
    value = inspect.unwrap(getattr(value, "py_func", value))  # of a compiled function; of one with a cache
    text = inspect.getdoc(value) or ""
    test = doctest.DocTestParser().get_doctest(text, {}, name, inspect.getsourcefile(value), 0)
    runner, said = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS), []
    runner.run(test, out=said.append, clear_globs=True)
    assert not said, "".join(said)
    return len(test.examples)


@pytest.mark.slow
@pytest.mark.parametrize(("room", "name"), exported(), ids=str)
def test_what_a_room_exports_has_an_example_that_is_true(room, name):
    value = getattr(importlib.import_module(f"npm_blender.core.{room}"), name)
    assert run_examples(value, f"{room}.{name}"), f"{room}.{name} has no example"


def on_the_ground() -> list[tuple[str, str]]:
    """(module, name) of every public function and class that a ground file defines."""
    found = []
    for name in sorted(GROUND):
        module = importlib.import_module(f"npm_blender.core.{name}")
        found += [(name, key) for key, value in vars(module).items() if not key.startswith("_")
                  and (inspect.isfunction(value) or inspect.isclass(value)) and value.__module__ == module.__name__]
    return found


@pytest.mark.parametrize(("module", "name"), on_the_ground(), ids=str)
def test_the_examples_of_the_ground_are_true(module, name):
    value = getattr(importlib.import_module(f"npm_blender.core.{module}"), name)
    assert run_examples(value, f"{module}.{name}") or module not in WITH_EXAMPLES, f"{module}.{name} has no example"
