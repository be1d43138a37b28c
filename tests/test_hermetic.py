"""Who may import what: the core knows no Blender, torch stays where gradients are, and starting is cheap."""
import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
CORE = sorted((ROOT / "npm_blender" / "core").glob("**/*.py"))
MAY_USE_TORCH = {"torch_backend.py"}


def imported(path: Path) -> set[str]:
    """Top names of all absolute imports in a file, wherever they stand in it."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            names.add(node.module.partition(".")[0])
    return names


def loaded_by(statement: str) -> set[str]:
    """The modules that a fresh Python has loaded after `statement`."""
    code = f"{statement}\nimport sys; print('@@', *sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    return set(done.stdout.rpartition("@@")[2].split())


@pytest.mark.parametrize("path", CORE, ids=lambda p: str(p.relative_to(ROOT)))
def test_core_never_imports_blender_and_torch_only_for_gradients(path):
    names = imported(path)
    assert not names & {"bpy", "bmesh", "mathutils", "gpu"}
    assert "torch" not in names or path.name in MAY_USE_TORCH


def test_importing_the_package_loads_nothing_heavy():
    assert not loaded_by("import npm_blender") & {"bpy", "torch", "numba", "numpy", "scipy"}


def test_help_loads_nothing_heavy():
    assert not loaded_by("from npm_blender.cli import main; main(['--help'])") & {"bpy", "torch", "numba", "numpy"}


def test_every_core_module_loads_without_blender_and_torch():
    files = [p.relative_to(ROOT).with_suffix("") for p in CORE if p.stem != "__init__" and p.name not in MAY_USE_TORCH]
    modules = [".".join(p.parts) for p in files]
    block = "import sys; sys.modules['bpy'] = sys.modules['torch'] = None  # importing them now raises ImportError\n"
    assert set(modules) <= loaded_by(block + "import " + ", ".join(modules))


def test_module_runs_as_a_program():
    command = [sys.executable, "-m", "npm_blender", "info", "none.npmesh"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stdout == "" and len(done.stderr.splitlines()) == 1 and "none.npmesh" in done.stderr
