"""Every function of the core states its types, but for compiled kernels: numba finds theirs, and mypy passes over them."""
import ast
from pathlib import Path

import pytest

CORE = Path(__file__).parents[2] / "npm_blender" / "core"
KERNEL = {"compiled", "njit"}


def is_kernel(node: ast.FunctionDef) -> bool:
    """Whether `compiled` or `njit` decorates the function, with options or without."""
    calls = [d.func if isinstance(d, ast.Call) else d for d in node.decorator_list]
    return any(isinstance(d, ast.Name) and d.id in KERNEL for d in calls)


def without_types(tree: ast.AST) -> list[str]:
    """Names of the functions that leave the type of an argument or of the result open; self and cls need none."""
    found = []
    for node in ast.walk(tree):
        if not isinstance(node, ast.FunctionDef) or is_kernel(node):
            continue
        a = node.args
        stated = [*a.posonlyargs, *a.args, *a.kwonlyargs, *filter(None, (a.vararg, a.kwarg))]
        open_ones = [arg.arg for arg in stated if arg.annotation is None and arg.arg not in ("self", "cls", "ctx")]
        if open_ones or (node.returns is None and node.name != "__init__"):
            found.append(f"{node.name} (line {node.lineno})")
    return found


@pytest.mark.parametrize("path", sorted(CORE.rglob("*.py")), ids=lambda p: str(p.relative_to(CORE)))
def test_every_function_but_a_kernel_states_its_types(path):
    assert without_types(ast.parse(path.read_text(encoding="utf-8"))) == []
