import shutil
import subprocess
import sys

import pytest

from npm_blender.core import jit
from npm_blender.core.cleaning.cleanup import clean
from npm_blender.core.levels.lod_sequence import build_lod
from npm_blender.core.settings import LodSettings
from tests.meshes.lod_meshes import sheet

MODULE = '''
from typing import NamedTuple
import numpy as np
from .jit import is_cold, njit

class Pair(NamedTuple):
    a: np.ndarray
    b: np.ndarray

@njit
def first(pair):
    return pair.a[0]

@njit
def both(pair):
    return first(pair) + pair.b[0]

before = is_cold(both)
print(both(Pair(np.array([3]), np.array([4]))), before, is_cold(both))
'''


@pytest.mark.slow
@pytest.mark.skipif(not jit.COMPILED, reason="numba is not installed")
def test_one_folder_under_two_import_names_keeps_two_caches(tmp_path):
    inner = tmp_path / "outer" / "inner"
    inner.mkdir(parents=True)
    shutil.copy(jit.__file__, inner / "jit.py")
    (inner / "module.py").write_text(MODULE)
    outer, plain = (tmp_path, "outer.inner.module"), (tmp_path / "outer", "inner.module")
    for (path, name), cold in ((outer, True), (plain, True), (outer, False)):
        done = subprocess.run([sys.executable, "-c", f"import sys; sys.path.insert(0, {str(path)!r}); import {name}"],
                              capture_output=True, text=True)
        assert done.stdout == f"7 {cold} False\n", done.stderr


def test_what_does_not_count_references_returns_no_array():
    from numba.core import types

    def parts(kind):
        return [kind, *(p for inner in kind for p in parts(inner))] if isinstance(kind, types.BaseTuple) else [kind]

    build_lod(clean(sheet(21, 21, noise=0.05), "auto")[0], LodSettings(base_faces=40, levels=2))
    checked = 0
    for name, module in sorted(sys.modules.items()):
        if not name.startswith("npm_blender.core."):
            continue
        for value in list(vars(module).values()):
            if not hasattr(value, "overloads") or value.targetoptions["_nrt"]:
                continue
            for overload in value.overloads.values():
                checked += 1
                assert not any(isinstance(p, types.Array) for p in parts(overload.signature.return_type)), value
    assert checked > 25
