"""What the demo lets Blender make. One child process: making the sculpt and rendering replace the open scene."""
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from npm_blender.core.mesh.topology import topology_of
from npm_blender.core.meshio.mesh_files import read_mesh

ROOT = Path(__file__).parent.parent.parent

CHILD = """
import sys
from pathlib import Path
import bpy, numpy as np
from npm_blender.core.mesh.triangle_mesh import TriMesh
from npm_blender.core.meshio.mesh_files import write_mesh
from npm_blender.demo import sculpt, sheet

out = Path(sys.argv[1])
mesh = sculpt.make_sculpt()
write_mesh(out / "whole.ply", mesh)
sculpt.VOXEL *= 3
for name in ("one.ply", "two.ply"):  # a ninth of the faces
    write_mesh(out / name, sculpt.make_sculpt())
sheet.PIXELS_PER_CELL = 64
box = TriMesh.from_arrays([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], [[0, 1, 2], [0, 2, 3]])
sheet.render_sheet([[sheet.Cell(mesh, "Sculpt", ("many faces",)), sheet.Cell(box, "Square", (), wire=True)],
                    [sheet.Cell(box, "Square", ())]], out / "sheet.png")
picture = bpy.data.images.load(str(out / "sheet.png"))
np.save(out / "sheet.npy", np.array(picture.pixels).reshape(picture.size[1], picture.size[0], 4)[::-1, :, :3])
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The folder that the child filled, and what it printed."""
    folder = tmp_path_factory.mktemp("blender")
    done = subprocess.run([sys.executable, "-c", CHILD, str(folder)], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder, done.stdout


def test_sculpt_is_one_closed_surface_without_handles_and_detailed(made):
    mesh = read_mesh(made[0] / "whole.ply")
    topology = topology_of(mesh.F)
    assert topology.faces >= 60_000
    assert (topology.components, topology.border_edges, topology.euler) == (1, 0, 2)
    assert mesh.face_areas().min() > 0


def test_sculpt_is_the_same_every_time(made):
    assert (made[0] / "one.ply").read_bytes() == (made[0] / "two.ply").read_bytes()


def test_sheet_shows_every_cell_and_leaves_missing_ones_empty(made):
    picture = np.load(made[0] / "sheet.npy")
    height, width = picture.shape[:2]
    paper = picture[0, 0]
    drawn = np.abs(picture - paper).max(2) > 0.1
    top, bottom = drawn[:height // 2], drawn[height // 2:]
    assert width == 128
    for half in (top[:, :width // 2], top[:, width // 2:], bottom[:, width // 4:3 * width // 4]):
        assert half.mean() > 0.1
    assert not bottom[:, :width // 4 - 4].any() and not bottom[:, 3 * width // 4 + 4:].any()


def test_sheet_is_written_whole(made):
    assert [path.name for path in made[0].glob("*.png")] == ["sheet.png"]
    assert not list(made[0].glob(".*"))


def test_blender_says_nothing_on_standard_output(made):
    assert made[1] == ""
