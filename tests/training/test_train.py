"""A few steps of the real training on two small sequences: it learns, resumes, and writes weights that load."""
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from npm_blender.core.meshio.mesh_files import write_mesh
from npm_blender.core.network import weights
from tests.meshes.shapes import bumpy
from training import sequences, train

pytestmark = [pytest.mark.slow, pytest.mark.torch]

ROOT = Path(__file__).parents[2]


def command(module, *arguments):
    """Output of a training script."""
    line = [sys.executable, "-m", module, *map(str, arguments)]
    return subprocess.run(line, cwd=ROOT, check=True, capture_output=True, text=True)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A folder of meshes, their sequences, and a run of a step or two that was then resumed for another."""
    folder = tmp_path_factory.mktemp("training")
    for i in range(10):
        write_mesh(folder / f"m{i}.ply", bumpy(3, seed=i))
    command("training.sequences", folder, folder / "sequences", "--variants", 1, "--processes", 1)
    first, second = ([folder / "sequences", folder / "run", "--hours", hours, "--val", 1] for hours in (1e-5, 2e-5))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["train", *map(str, first)])
        train.main()  # once time is up, a run ends with the step that it is in
    command("training.train", *second)
    return folder


def test_plain_folder_is_split_and_every_sequence_is_built(run):
    assert len(list((run / "sequences/val").glob("*.npz"))) == 1
    assert len(list((run / "sequences/train").glob("*.npz"))) == 9 + 9 + 3
    with np.load(run / "sequences/train/m0.b100.npz", allow_pickle=False) as z:
        assert z["F0"].shape == (100, 3) and z["levels"] == 4 and np.isfinite(z["V"]).all()


def test_variants_are_other_bases_of_the_same_mesh(run):
    with np.load(run / "sequences/train/m0.npz") as a, np.load(run / "sequences/train/m0.v1.npz") as b:
        assert a["F0"].shape == b["F0"].shape and not np.array_equal(a["V0"], b["V0"])


def test_run_resumes_and_logs(run):
    lines = (run / "run/log.csv").read_text().splitlines()
    steps = [int(line.split(",")[0]) for line in lines[1:]]
    assert lines[0].startswith("step,seconds,loss") and len(steps) == 2 and steps[1] > steps[0] > 0


def test_weights_of_a_run_load(run):
    found = weights.load_weights("weights", run / "run")
    assert found.config.decoder and len(found.digest) == 8


def test_sequences_are_the_paper_s_whatever_the_product_s_defaults_are(tmp_path):
    for i in range(10):
        (tmp_path / f"m{i}.ply").touch()
    found = {task.name: task.settings for task in sequences.tasks(tmp_path, tmp_path / "out", 1)}
    assert {(s.base_faces, s.levels) for name, s in found.items() if not name.endswith(".b100")} == {(400, 3)}
    assert found["train/m0"].variant == 0 and found["train/m0.v1"].variant == 1
    assert (found["train/m0.b100"].base_faces, found["train/m0.b100"].levels) == (100, 4)


def test_a_folder_without_meshes_is_an_error(tmp_path):
    with pytest.raises(Exception, match="found none"):
        sequences.tasks(tmp_path, tmp_path / "out", 1)
