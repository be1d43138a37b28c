"""Neural Subdivision: what it is before training, what motions do to it, that it learns, resumes and says what is wrong."""
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch

from npm_blender.core.errors import FileError, WeightsError
from npm_blender.core.mesh.subdivision import hierarchy, midpoints
from npm_blender.core.mesh.triangle_mesh import TriMesh
from npm_blender.core.meshio.mesh_files import write_mesh
from npm_blender.core.settings import LodSettings
from tests.meshes.shapes import bumpy, grid, icosphere, torus
from training import sequences
from training.neural_subdivision import train
from training.neural_subdivision.flaps import Flaps, Frames, differential
from training.neural_subdivision.network import NeuralSubdivision, read, subdivide
from training.neural_subdivision.train import Pair, TrainConfig, Trainer, objective

ROOT = Path(__file__).parents[2]
WEIGHTS = ROOT / "training/runs/neural_subdivision/weights.npz"


@pytest.fixture(autouse=True, scope="module")
def one_thread():
    """Sums in one order."""
    torch.set_num_threads(1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two training sequences and one of validation, 100 base faces and three levels."""
    out = tmp_path_factory.mktemp("sequences")
    for split, seed in (("train", 0), ("train", 1), ("val", 2)):
        (out / split).mkdir(exist_ok=True)
        write_mesh(out / "mesh.ply", bumpy(4, seed=seed))
        path = out / split / f"m{seed}.npz"
        sequences.build(sequences.Task("m", out / "mesh.ply", path, LodSettings(base_faces=100, levels=3)))
    return out


def scrambled(seed: int = 0, size: float = 0.3) -> NeuralSubdivision:
    """A network in which nothing is zero."""
    torch.manual_seed(seed)
    network = NeuralSubdivision()
    with torch.no_grad():
        for p in network.parameters():
            p.add_(size * torch.randn(p.shape) * (0.2 if p.ndim > 1 else 1))
    return network


@pytest.mark.parametrize("mesh", [icosphere(1), grid(6), torus(12, 8)], ids=["closed", "open", "genus 1"])
def test_untrained_network_is_midpoint_subdivision(mesh):
    V = mesh.V
    for level, made in zip(hierarchy(mesh.F, len(V), 2), subdivide(NeuralSubdivision(), mesh, 2)):
        assert np.array_equal(made.F, level.F)
        np.testing.assert_allclose(made.V, V, atol=2e-6)
        V = midpoints(V, level)


@pytest.mark.parametrize("mesh", [bumpy(1), grid(5)], ids=["closed", "open"])
def test_motions_and_scaling_commute_with_it(mesh):
    Q = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    Q *= np.sign(np.linalg.det(Q))
    network = scrambled()
    here = subdivide(network, mesh, 2)[-1].V
    there = subdivide(network, TriMesh(2.5 * mesh.V @ Q.T + [3, -2, 1], mesh.F), 2)[-1].V
    assert np.abs(here - subdivide(NeuralSubdivision(), mesh, 2)[-1].V).max() > 0.05
    np.testing.assert_allclose(there, 2.5 * here @ Q.T + [3, -2, 1], atol=2e-4)


def test_numbering_of_the_base_does_not_matter():
    mesh, network = bumpy(1), scrambled()
    order = np.random.default_rng(0).permutation(len(mesh.V))
    other = TriMesh(mesh.V[order], np.argsort(order).astype(np.int32)[np.roll(mesh.F[::-1], 1, 1)])
    one, two = (subdivide(network, x, 1)[1].V for x in (mesh, other))
    nearest = np.linalg.norm(one[:, None] - two[None], axis=2).min(1)
    assert nearest.max() < 1e-4


def test_flat_sheet_has_one_normal_and_straight_borders_do_not_bend():
    sheet = grid(4, height=0.0)
    flaps = Flaps.of(hierarchy(sheet.F, len(sheet.V), 0)[0])
    V = torch.from_numpy(sheet.V.astype(np.float32))
    frames = Frames.of(V, flaps)
    assert bool((flaps.inner == 0).any())
    torch.testing.assert_close(frames.z, torch.tensor([[0.0, 0.0, 1.0]]).expand_as(frames.z))
    corner = (V.abs() > 0.99).all(1) | ((V[:, :2].abs() > 0.99).sum(1) == 2)
    assert differential(V, flaps)[~corner].norm(dim=1).max() < 1e-6
    assert differential(V, flaps)[corner].norm(dim=1).min() > 0.1


def test_every_parameter_gets_a_gradient(folder):
    pair, network = Pair.read(folder / "train/m0.npz"), scrambled(size=0.02)
    objective(pair, network(pair.V0, pair.levels)).backward()
    for name, p in network.named_parameters():
        assert torch.isfinite(p.grad).all() and (p.grad.abs().max() > 0), name


def test_degenerate_faces_give_finite_gradients():
    mesh = icosphere(1)
    V = mesh.V.copy()
    V[mesh.F[0, 1]] = V[mesh.F[0, 0]]
    V[mesh.F[5]] = V[mesh.F[5]].mean(0)
    x = torch.from_numpy(V.astype(np.float32)).requires_grad_(True)
    levels = [Flaps.of(level) for level in hierarchy(mesh.F, len(V), 1)]
    sum(p.square().sum() for p in scrambled(size=0.02)(x, levels)).backward()
    assert torch.isfinite(x.grad).all()


@pytest.mark.slow
def test_training_lowers_the_loss_on_what_it_sees(folder, tmp_path):
    trainer = Trainer(folder, tmp_path / "run", TrainConfig())
    losses = [trainer.train_step(0.0) for _ in range(60)]
    assert np.mean(losses[-10:]) < 0.9 * np.mean(losses[:4])


@pytest.mark.slow
def test_a_resumed_run_is_the_run_that_was_not_interrupted(folder, tmp_path):
    config = TrainConfig()
    whole, first = Trainer(folder, tmp_path / "whole", config), Trainer(folder, tmp_path / "parts", config)
    for _ in range(8):
        whole.train_step(0.1)
    for _ in range(5):
        first.train_step(0.1)
    first.checkpoint(seconds=7.0)
    second = Trainer(folder, tmp_path / "parts", config)
    assert (second.step, second.seconds) == (5, 7.0)
    for _ in range(3):
        second.train_step(0.1)
    for module in ("network", "average"):
        for a, b in zip(getattr(whole, module).parameters(), getattr(second, module).parameters(), strict=True):
            torch.testing.assert_close(a, b, rtol=0, atol=0)


@pytest.mark.slow
def test_command_trains_logs_and_writes_weights_that_load(folder, tmp_path):
    line = [sys.executable, "-m", "training.neural_subdivision.train", str(folder), str(tmp_path / "run")]
    subprocess.run([*line, "--hours", "1e-5", "--val", "1"], cwd=ROOT, check=True, capture_output=True)
    rows = (tmp_path / "run/log.csv").read_text().splitlines()
    assert rows[0].startswith("step,seconds,loss,base,network") and len(rows) == 2
    assert len(subdivide(read(tmp_path / "run/weights.npz"), icosphere(1), 1)[1].F) == 320


def test_without_sequences_one_line_says_so(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["train", str(tmp_path), str(tmp_path / "run")])
    with pytest.raises(SystemExit) as end:
        train.main()
    *usage, line = capsys.readouterr().err.splitlines()
    assert end.value.code == 2 and "found none" in line and all("error" not in other for other in usage)


def test_sequences_of_another_depth_do_not_count(folder, tmp_path):
    for split in ("train", "val"):
        (tmp_path / split).mkdir()
        with np.load(folder / "train/m0.npz") as z:
            np.savez(tmp_path / split / "m.npz", **{**z, "levels": np.int64(4)})
    with pytest.raises(FileError, match="of 3 levels"):
        Trainer(tmp_path, tmp_path / "run", TrainConfig())


@pytest.mark.parametrize("data", [b"", b"not a zip", None], ids=["empty", "noise", "other arrays"])
def test_damaged_files_are_one_line(folder, tmp_path, data):
    weights, run = tmp_path / "weights.npz", tmp_path / "run"
    run.mkdir()
    if data is None:
        np.savez(weights, other=np.zeros(3))
    else:
        weights.write_bytes(data)
    (run / "checkpoint.npz").write_bytes(weights.read_bytes())
    with pytest.raises(WeightsError, match="damaged") as one:
        read(weights)
    with pytest.raises(FileError, match="damaged") as two:
        Trainer(folder, run, TrainConfig())
    assert "\n" not in str(one.value) + str(two.value)


def test_missing_weights_are_one_line(tmp_path):
    with pytest.raises(FileError, match="found none"):
        read(tmp_path / "weights.npz")


def test_shipped_weights_make_a_coarse_sphere_rounder():
    coarse, network = icosphere(1), read(WEIGHTS)
    made, flat = subdivide(network, coarse)[-1].V, subdivide(NeuralSubdivision(), coarse)[-1].V
    error = [np.abs(np.linalg.norm(V, axis=1) - 1).mean() for V in (made, flat)]
    assert error[0] < 0.8 * error[1]
