"""Blender's own extension tool: of a real Blender, or of the bpy module, which brings the same program."""
import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

from .staging import ROOT


class ToolError(RuntimeError):
    """There is no Blender to build with, or it refused."""


def program() -> Path | None:
    """The extension tool of the bpy module; it needs Python only, and bpy is not loaded."""
    spec = importlib.util.find_spec("bpy")
    folders = spec.submodule_search_locations or [] if spec else []
    found = sorted(p for f in folders for p in Path(f).glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py"))
    return found[-1] if found else None


def command(blender: str | None = None) -> list[str]:
    """The command that `build` and `validate` are arguments of.

    blender: how a Blender is started, in words for a shell; else the environment's BLENDER, else a `blender` that is
    installed, else the bpy module. Raises ToolError.
    """
    words = shlex.split(blender or os.environ.get("BLENDER", "")) or [shutil.which("blender")]
    if words != [None]:
        if shutil.which(words[0]) is None:
            raise ToolError(f"Expected a program to start Blender, found none called {words[0]}; "
                            "correct BLENDER, or leave it out")
        return [*words, "--command", "extension"]
    tool = program()
    if tool is None:
        raise ToolError("Expected Blender or its Python module to build with, found neither; run make extension, "
                        "which installs the module, or give BLENDER=path")
    return [sys.executable, str(tool)]


def run(tool: list[str], verb: str, *arguments: str) -> str:
    """What the tool says to `verb`, run in the project's root. Raises ToolError with it where the tool refuses."""
    if len(tool) == 2:  # a real Blender knows its tags by itself
        tags = Path(tool[1]).parents[3] / "modules" / "_bpy_internal" / "extensions" / "tags.py"
        arguments = (*arguments, f"--valid-tags={tags}") if tags.exists() else arguments
    done = subprocess.run([*tool, verb, *arguments], cwd=ROOT, capture_output=True, text=True)
    said = (done.stdout + done.stderr).strip()
    if done.returncode:
        raise ToolError(f"Expected Blender to {verb} the extension, found:\n{said}")
    return said
