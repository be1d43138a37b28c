import shutil
import subprocess
import sys

import pytest

from npm_blender.core import jit

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
