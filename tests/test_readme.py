"""The Python in README runs as it stands there."""
import re
from pathlib import Path

import numpy as np
import pytest

from npm_blender.core import open_stream
from tests.few_points import compare_by_few_points

ROOT = Path(__file__).parent.parent
BLOCKS = re.findall(r"^```python\n(.*?)^```$", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


def test_readme_begins_with_the_front_door():
    assert len(BLOCKS) == 1
    assert "from npm_blender.core import TriMesh, compress, open_stream" in BLOCKS[0].splitlines()


@pytest.mark.slow
def test_the_snippet_runs_and_gives_a_mesh_near_the_input(monkeypatch):
    compare_by_few_points(monkeypatch)
    names = {}
    exec(compile(BLOCKS[0], "README.md", "exec"), names)  # noqa: S102
    data, mesh = names["data"], names["mesh"]
    assert isinstance(data, bytes) and open_stream(data).total_features > 0
    assert mesh.F.shape[1] == 3
    assert np.abs(np.ptp(mesh.V, axis=0) - np.ptp(names["V"], axis=0)).max() < 0.1 * np.ptp(names["V"])
