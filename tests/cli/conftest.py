"""A small mesh made in code, and a way to run a command and see all that a user sees."""
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from npm_blender.cli import main
from npm_blender.core.mesh.subdivision import hierarchy, midpoints
from npm_blender.core.mesh.triangle_mesh import TriMesh
from npm_blender.core.meshio.mesh_files import write_mesh
from tests.few_points import compare_by_few_points


def bumpy_sphere(levels: int = 4) -> TriMesh:
    """An octahedron's subdivision (8 * 4^levels faces), rounded and made bumpy."""
    V = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
    F = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
    steps = hierarchy(F, 6, levels)
    for level in steps[:-1]:
        V = midpoints(V, level)
        V /= np.linalg.norm(V, axis=1, keepdims=True)
    return TriMesh.from_arrays(V * (1 + 0.05 * np.sin(9 * V).prod(1) + 0.1 * np.cos(4 * V[:, 2]))[:, None], steps[-1].F)


class Outcome(NamedTuple):
    """What a command leaves on the screen, and its exit code."""

    code: int
    out: str
    err: str

    @property
    def error_line(self) -> str:
        """The one error line; fails if there is another, or a traceback."""
        lines = [line for line in self.err.splitlines() if "error: " in line]
        assert len(lines) == 1, self.err
        assert "Traceback" not in self.err
        return lines[0]


@pytest.fixture(scope="package", autouse=True)
def quick_streams():
    """How near a stream is to its mesh is tested elsewhere."""
    with pytest.MonkeyPatch.context() as patch:
        compare_by_few_points(patch)
        yield


@pytest.fixture
def run(capfd):
    """run(*arguments) -> Outcome."""
    def run(*arguments: object) -> Outcome:
        capfd.readouterr()
        code = main([str(a) for a in arguments], prog="npmesh")
        return Outcome(code, *capfd.readouterr())

    return run


@pytest.fixture(scope="session")
def sphere_file(tmp_path_factory) -> Path:
    """A .ply of 2,048 faces."""
    path = tmp_path_factory.mktemp("meshes") / "sphere.ply"
    write_mesh(path, bumpy_sphere())
    return path
