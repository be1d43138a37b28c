"""The same tests in a real Blender: blender -b --factory-startup --python-exit-code 1 -P tests/addon/run_in_blender.py

Arguments for pytest follow `--`. Blender's Python needs pytest, numba and trimesh.
"""
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parent
arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
sys.path.insert(0, str(TESTS.parents[1]))
sys.exit(pytest.main([str(TESTS), "--rootdir", str(TESTS.parents[1]), "-p", "no:cacheprovider", *arguments]))
