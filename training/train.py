"""Train the encoder and decoder: `python -m training.train SEQUENCES OUT [--hours H] [--init WEIGHTS]`.

SEQUENCES holds train/ and val/ folders of cached LoD sequences (see `training.sequences`). OUT gets checkpoint.npz
(resumed from when present), bases, log.csv and the weights; `training.curve` draws the log. Each step takes one
sequence: encode, keep a random prefix of the features (none, some, all), add quantization noise, decode, and move the
network - and, when no features are kept, the base of that sequence - against the losses. With --processes each has its
share of the sequences, and gradients are averaged.
"""

import argparse
import csv
import json
import os
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import torch
import torch.distributed as parallel
import torch.multiprocessing

from npm_blender.core.network import (
    NetworkConfig,
    TorchBackend,
    decode,
    encode,
    flatten_tree,
    folded,
    initial_parameters,
    map_tree,
    save_weights,
    unflatten_tree,
)

from . import losses
from .samples import Sample, encoder_inputs, load


@dataclass(frozen=True)
class TrainConfig:
    """All knobs."""

    network: NetworkConfig = NetworkConfig()
    hours: float = 2.0  # length of the run, and of the cosine schedule
    learning_rate: float = 1e-3  # Adam, as the paper
    weight_decay: float = 1e-6  # as the paper
    base_rate: float = 8e-4  # Adam on the base positions, unit cube
    tangential: float = 0.04  # weight of the sliding part of L_corr
    coarse: float = 0.3  # weight of L_corr at the levels before the last
    jacobian: float = 0.5  # weight of L_jacobian
    sparsity: float = 0.01  # weight of L_sparsity
    noise: float = 0.25  # quantization step of the features
    kept: tuple[float, ...] = (0.4, 0.35, 0.25)  # chance of: no features, a random number of them, all
    gradient_norm: float = 2.0
    average: float = 0.998  # of the moving average of the weights, which is what ships
    validate_every: int = 1000
    warm_up: int = 500  # steps in which the statistics of batch normalization are gathered; then they stay
    seed: int = 0


def random_prefix(features: list, sample: Sample, random: np.random.Generator) -> list:
    """A random prefix of the features in order of magnitude (times edge length and area), zeros elsewhere."""
    score = [
        f.detach().norm(dim=1) * s * torch.exp(0.5 * torch.randn(len(f)))
        for f, s in zip(features, sample.face_scale, strict=True)
    ]
    total = sum(len(s) for s in score)
    count = int(10 * (total / 10) ** random.random())
    threshold = torch.cat(score).topk(count).values[-1]
    return [f * (s >= threshold)[:, None] for f, s in zip(features, score, strict=True)]


def objective(B, config: TrainConfig, sample: Sample, decoded: list):
    """L_corr + L_jacobian of the decoded levels; hard meshes count by the root of their error."""
    weight = (losses.UNIT / sample.scale) ** 0.5
    total = 0
    for i, (V, target, w) in enumerate(zip(decoded, sample.targets, sample.vertex_weights, strict=True), 1):
        level = 1.0 if i == sample.levels else config.coarse
        total = total + level * losses.correspondence(V, target, sample.normals[: len(V)], w, config.tangential)
    bend = losses.normal_jacobian(B, decoded[-1], sample.meshes[-1], sample.face_normals, sample.face_weights)
    return weight * total + config.jacobian * bend


def base_step(sample: Sample, gradient, rate: float) -> None:
    """One Adam step on the base of a sample."""
    if not sample.moments:
        sample.moments[:] = [torch.zeros_like(gradient), torch.zeros_like(gradient), 0]
    first, second, count = sample.moments
    gradient = gradient.clamp(-100, 100)
    count += 1
    first.lerp_(gradient, 0.1)
    second.lerp_(gradient * gradient, 0.01)
    with torch.no_grad():
        sample.V0 -= rate * (first / (1 - 0.9**count)) / ((second / (1 - 0.99**count)).sqrt() + 1e-8)
    sample.moments[2] = count


def validate(B, params: dict, samples: list, config: TrainConfig, base_steps: int) -> dict:
    """Area-weighted mean distance along the normal at level L, x1e-4, for no, 40, 400 and all features; and of the base."""
    sums = {"base": 0.0, "0": 0.0, "40": 0.0, "400": 0.0, "all": 0.0, "degrees_0": 0.0, "degrees_all": 0.0}
    for sample in samples:
        none = [torch.zeros(m.m, 8) for m in sample.meshes[:-1]]
        for _ in range(base_steps):
            V0 = sample.V0.clone().requires_grad_(True)
            loss = objective(B, config, sample, decode(B, params, V0, none, sample.meshes[:-1]))
            base_step(sample, torch.autograd.grad(loss, V0)[0], config.base_rate)
        with torch.no_grad():
            features = encode(B, params, [sample.V0, *sample.targets], sample.meshes, encoder_inputs(B, sample))
            score = torch.cat([f.norm(dim=1) * s for f, s in zip(features, sample.face_scale, strict=True)])
            sums["base"] += sample.scale
            for count in (0, 40, 400, "all"):
                k = len(score) if count == "all" else count
                mask = torch.zeros(len(score), dtype=torch.bool)
                mask[score.topk(k).indices] = True
                parts = torch.split(mask, [len(f) for f in features])
                V = decode(
                    B,
                    params,
                    sample.V0,
                    [f * p[:, None] for f, p in zip(features, parts, strict=True)],
                    sample.meshes[:-1],
                )[-1]
                error = ((V - sample.targets[-1]) * sample.normals).sum(1).abs()
                sums[str(count)] += float((error * sample.vertex_weights[-1]).sum())
                if f"degrees_{count}" in sums:
                    bend = losses.normal_jacobian(B, V, sample.meshes[-1], sample.face_normals, sample.face_weights)
                    sums[f"degrees_{count}"] += float(2 * torch.arcsin(bend / 2)) * 180 / np.pi * 1e-4
    return {k: v / len(samples) * 1e4 for k, v in sums.items()}


def save(path: Path, state: dict) -> None:
    """Write a checkpoint: nested dicts of arrays, no pickle."""
    temporary = path.with_suffix(".tmp.npz")
    np.savez(temporary, **state)
    temporary.replace(path)


class Trainer:
    """One process of the run: parameters, optimiser, moving average, this process's share of the samples."""

    def __init__(self, options: argparse.Namespace, rank: int) -> None:
        self.options, self.rank, self.out = options, rank, options.out
        self.config = TrainConfig(hours=options.hours, learning_rate=options.rate)
        self.random = np.random.default_rng([self.config.seed, rank, int(time.time())])
        torch.manual_seed(self.config.seed + rank)
        self.B, self.quiet = TorchBackend(), TorchBackend()
        self.paths = sorted((options.sequences / "train").glob("*.npz"))[rank :: options.processes]
        found = sorted((options.sequences / "val").glob("*.npz"))
        self.val = (
            [load(p, self.quiet) for p in found[:: max(1, len(found) // options.val)][: options.val]]
            if rank == 0
            else []
        )
        self.samples: dict[Path, Sample] = {}
        self.params = map_tree(torch.from_numpy, initial_parameters(self.config.network, self.config.seed))
        self.leaves = flatten_tree(self.params)
        self.trained = {k: v.requires_grad_(True) for k, v in self.leaves.items() if not k.endswith((".mean", ".var"))}
        self.optimiser = torch.optim.Adam(
            list(self.trained.values()), lr=self.config.learning_rate, weight_decay=self.config.weight_decay
        )
        self.average = {k: v.detach().clone() for k, v in self.leaves.items()}
        self.step, self.trained_seconds, self.running = 0, 0.0, []
        self.bases = self._restore()
        for sample in self.val:
            sample.V0 = self.bases.get(sample.name, sample.V0)

    def _restore(self) -> dict:
        """State of OUT's checkpoint, or the network of --init; returns the bases known so far."""
        checkpoint = self.out / "checkpoint.npz"
        source = checkpoint if checkpoint.exists() else self.options.init
        if source is None:
            return {}
        with np.load(source, allow_pickle=False) as z:
            for k, v in self.leaves.items():
                v.data.copy_(torch.from_numpy(z["p:" + k]))
                self.average[k].copy_(torch.from_numpy(z["a:" + k]))
            if source == checkpoint:
                self.step, self.trained_seconds = int(z["step"]), float(z["seconds"])
                for k, v in self.trained.items():
                    if "m:" + k in z.files:
                        self.optimiser.state[v] = {
                            "step": torch.tensor(float(self.step)),
                            "exp_avg": torch.from_numpy(z["m:" + k]),
                            "exp_avg_sq": torch.from_numpy(z["v:" + k]),
                        }
            else:
                self.step = self.config.warm_up
        bases = {}
        for path in source.parent.glob("bases.*.npz"):
            with np.load(path, allow_pickle=False) as z:
                bases.update({k: torch.from_numpy(z[k]) for k in z.files})
        return bases

    def _sample(self) -> Sample:
        """A random sample of this process's share, kept in memory once loaded."""
        path = self.paths[self.random.integers(len(self.paths))]
        if path not in self.samples:
            sample = load(path, self.B)
            sample.V0 = self.bases.get(sample.name, sample.V0)
            self.samples[path] = sample
        return self.samples[path]

    def _average_gradients(self) -> None:
        """Mean of the gradients of all processes."""
        flat = torch.cat(
            [torch.zeros_like(v).reshape(-1) if v.grad is None else v.grad.reshape(-1) for v in self.trained.values()]
        )
        if self.options.processes > 1:
            parallel.all_reduce(flat)
            flat /= self.options.processes
        for v, g in zip(self.trained.values(), flat.split([v.numel() for v in self.trained.values()]), strict=True):
            v.grad = g.reshape(v.shape)

    def train_step(self, progress: float) -> None:
        """One sample, forward, backward, update; progress in 0..1 along the schedule."""
        config, B, params = self.config, self.B, self.params
        for group in self.optimiser.param_groups:
            group["lr"] = (
                config.learning_rate
                * min(1, (self.step + 1) / 200)
                * (0.02 + 0.98 * (1 + np.cos(np.pi * progress)) / 2)
            )
        B.momentum = 1 / (self.step + 2) if self.step < config.warm_up else None
        sample = self._sample()
        V0 = sample.V0.clone().requires_grad_(True)
        kind = ("none", "some", "all")[int(np.searchsorted(np.cumsum(config.kept), self.random.random()))]
        if kind == "none":
            kept, cost = [torch.zeros(mesh.m, 8) for mesh in sample.meshes[:-1]], 0
        else:
            kept = encode(B, params, [sample.V0, *sample.targets], sample.meshes, encoder_inputs(B, sample))
            cost = config.sparsity * losses.sparsity(kept)
            if kind == "some":
                kept = random_prefix(kept, sample, self.random)
            kept = [f + (torch.rand_like(f) - 0.5) * config.noise * (f != 0) for f in kept]
        loss = objective(B, config, sample, decode(B, params, V0, kept, sample.meshes[:-1]))
        self.optimiser.zero_grad()
        (loss + cost).backward()
        self._average_gradients()
        norm = torch.nn.utils.clip_grad_norm_(list(self.trained.values()), config.gradient_norm)
        if torch.isfinite(norm):
            self.optimiser.step()
        if kind == "none" and bool(torch.isfinite(V0.grad).all()):
            base_step(sample, V0.grad, config.base_rate * (1 - 0.7 * progress))
        decay = min(config.average, (self.step + 1) / (self.step + 10))
        with torch.no_grad():
            for k, v in self.leaves.items():
                self.average[k].lerp_(v, 1 - decay)
        if torch.isfinite(loss):
            self.running.append(float(loss.detach()))
        self.step += 1

    def checkpoint(self, seconds: float) -> None:
        """Write this process's bases; in the first process also validate, log, and write the checkpoint and the weights."""
        known = {
            **{k: v.numpy() for k, v in self.bases.items()},
            **{s.name: s.V0.numpy() for s in [*self.samples.values(), *self.val]},
        }
        save(self.out / f"bases.{self.rank}.npz", known)
        if self.rank:
            return
        result = validate(self.quiet, unflatten_tree(self.average), self.val, self.config, base_steps=6)
        row = {
            "step": self.step,
            "seconds": round(seconds),
            "loss": round(float(np.mean(self.running or [0])), 4),
            **{k: round(v, 3) for k, v in result.items()},
        }
        self.running = []
        print(json.dumps(row), flush=True)
        state = {
            "step": np.int64(self.step),
            "seconds": np.float64(seconds),
            "config": np.array(json.dumps(asdict(self.config))),
        }
        for k, v in self.leaves.items():
            state["p:" + k], state["a:" + k] = v.detach().numpy(), self.average[k].numpy()
        for k, v in self.trained.items():
            if v in self.optimiser.state:
                state["m:" + k], state["v:" + k] = (
                    self.optimiser.state[v][n].numpy() for n in ("exp_avg", "exp_avg_sq")
                )
        save(self.out / "checkpoint.npz", state)
        folded_tree = folded(unflatten_tree({k: v.numpy() for k, v in self.average.items()}))
        save_weights(self.out / "weights.npz", folded_tree, self.config.network)
        log = self.out / "log.csv"
        new = not log.exists()
        with log.open("a", newline="") as f:
            writer = csv.DictWriter(f, row.keys())
            if new:
                writer.writeheader()
            writer.writerow(row)


def run(rank: int, options: argparse.Namespace) -> None:
    """The loop of one process."""
    torch.set_num_threads(1)
    if options.processes > 1:
        os.environ.update(MASTER_ADDR="127.0.0.1", MASTER_PORT="29533")
        parallel.init_process_group("gloo", rank=rank, world_size=options.processes)
    trainer = Trainer(options, rank)
    begun, done = time.time() - trainer.trained_seconds, False
    while not done:
        seconds = time.time() - begun
        clock = torch.tensor([seconds / (options.hours * 3600)], dtype=torch.float64)
        if options.processes > 1:
            parallel.broadcast(clock, 0)
        trainer.train_step(min(1.0, float(clock)))
        done = float(clock) >= 1
        if done or trainer.step % trainer.config.validate_every == 0:
            trainer.checkpoint(seconds)


def main() -> None:
    """Read the options, then train until the time is used up."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("sequences", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--hours", type=float, default=TrainConfig.hours, help="in all, over resumed runs")
    parser.add_argument("--rate", type=float, default=TrainConfig.learning_rate)
    parser.add_argument(
        "--init", type=Path, help="checkpoint whose network and bases to start from, with a new schedule"
    )
    parser.add_argument("--val", type=int, default=16, help="validation sequences")
    parser.add_argument("--processes", type=int, default=1)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    if options.processes == 1:
        run(0, options)
    else:
        torch.multiprocessing.spawn(run, (options,), options.processes)


if __name__ == "__main__":
    main()
