"""Train the baseline: `python -m training.neural_subdivision.train SEQUENCES OUT [--hours H]`.

SEQUENCES holds train/ and val/ folders of cached LoD sequences (see `training.sequences`). OUT gets checkpoint.npz
(resumed from when present), log.csv and weights.npz. Each step takes one sequence, subdivides its base and moves the
network against the distances to the corresponding points of the input, means over the vertices of a level, summed over
all levels, the base included. The publication squares them; on a corpus of boxes and coral that learns from the coral
alone, and dividing by what midpoints leave learns from the boxes alone (both were tried). Most steps end a level early
(the publication's all do), at a quarter of the cost.
"""

import argparse
import csv
import json
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import torch

from npm_blender.core.errors import FileError
from npm_blender.core.mesh import hierarchy
from npm_blender.core.network import TorchBackend

from ..samples import load
from ..train import save
from .flaps import Flaps
from .network import NeuralSubdivision

LEVELS = 3
UNIT = 1e-2  # of the unit cube: the distance that counts as one


@dataclass(frozen=True)
class TrainConfig:
    """All knobs."""

    hours: float = 1.0  # length of the run, and of the cosine schedule
    learning_rate: float = 2e-3  # Adam, as the publication
    gradient_norm: float = 2.0
    early: float = 0.85  # chance that a step leaves out the finest level
    average: float = 0.998  # of the moving average of the weights, which is what ships
    validate_every: int = 300
    seed: int = 0


@dataclass(frozen=True)
class Pair:
    """What a step needs of one sequence.

    V0 (n0, 3): the base; levels: flaps of levels 0..L-1; target (n_L, 3): V^0..V^L, the vertices of a level being a prefix
    of the finest's; normal (n_L, 3) of the input there; weight (n_L,): share of the area; scale: see `samples.Sample`.
    """

    V0: torch.Tensor
    levels: list[Flaps]
    target: torch.Tensor
    normal: torch.Tensor
    weight: torch.Tensor
    scale: float

    @staticmethod
    def read(path: Path) -> "Pair":
        """The pair of a cached sequence."""
        sample = load(path, TorchBackend())
        F0 = sample.meshes[0].F.reshape(-1, 3).numpy()
        lods = hierarchy(F0, len(sample.V0), sample.levels - 1)
        flaps, weight = [Flaps.of(level) for level in lods], sample.vertex_weights[-1]
        return Pair(sample.V0, flaps, sample.targets[-1], sample.normals, weight, sample.scale)


def objective(pair: Pair, positions: list[torch.Tensor]) -> torch.Tensor:
    """Mean distances to the targets over UNIT, summed over levels 0..L; a step may end before the finest level."""
    parts = ((V - pair.target[: len(V)]).square().sum(1) for V in positions)
    return sum((squares + 1e-10).sqrt().mean() / UNIT for squares in parts)


def validate(network: NeuralSubdivision, pairs: list[Pair]) -> dict:
    """Mean distance along the normal at the finest level, x1e-4, of the midpoints of the base and of the network; the loss."""
    sums = {"base": 0.0, "network": 0.0, "loss": 0.0}
    with torch.no_grad():
        for pair in pairs:
            positions = network(pair.V0, pair.levels)
            error = ((positions[-1] - pair.target) * pair.normal).sum(1).abs()
            sums["base"] += pair.scale * 1e4
            sums["network"] += float((error * pair.weight).sum()) * 1e4
            sums["loss"] += float(objective(pair, positions))
    return {k: v / len(pairs) for k, v in sums.items()}


def found(folder: Path, count: int, levels: int = LEVELS) -> list[Path]:
    """At most `count` sequences of so many levels in a folder. Raises FileError if there are none."""
    paths, everything = [], sorted(folder.glob("*.npz"))
    for path in everything[:: max(1, len(everything) // count)]:
        with np.load(path, allow_pickle=False) as z:
            if "levels" not in z.files or int(z["levels"]) == levels:
                paths.append(path)
    if not paths:
        raise FileError(
            f"Expected LoD sequences of {levels} levels in {folder}, found none; make them with python -m training.sequences"
        )
    return paths[:count]


class Trainer:
    """Network, optimiser, moving average, and the sequences read so far."""

    def __init__(self, sequences: Path, out: Path, config: TrainConfig, train: int = 400, val: int = 12) -> None:
        """sequences: folder with train/ and val/; out: made if missing; train, val: use so many, spread over the names.

        Raises FileError if there are no sequences, or the checkpoint in `out` is damaged.
        """
        self.config, self.out = config, out
        self.paths = found(sequences / "train", train)
        self.val = [Pair.read(p) for p in found(sequences / "val", val)]
        self.pairs: dict[Path, Pair] = {}
        torch.manual_seed(config.seed)
        self.network = NeuralSubdivision()
        self.average = NeuralSubdivision()
        self.average.load_state_dict(self.network.state_dict())
        self.optimiser = torch.optim.Adam(self.network.parameters(), lr=config.learning_rate)
        self.step, self.seconds, self.losses = 0, 0.0, []
        out.mkdir(parents=True, exist_ok=True)
        self._restore()

    def _restore(self) -> None:
        """Go on from OUT's checkpoint, if there is one."""
        path = self.out / "checkpoint.npz"
        if not path.exists():
            return
        try:
            with np.load(path, allow_pickle=False) as z:
                self.step, self.seconds = int(z["step"]), float(z["seconds"])
                for prefix, module in (("p:", self.network), ("a:", self.average)):
                    module.load_state_dict({k: torch.from_numpy(z[prefix + k]) for k in module.state_dict()})
                for name, value in self.network.named_parameters():
                    self.optimiser.state[value] = {
                        "step": torch.tensor(float(self.step)),
                        "exp_avg": torch.from_numpy(z["m:" + name]),
                        "exp_avg_sq": torch.from_numpy(z["v:" + name]),
                    }
        except Exception as error:  # zip, NumPy and torch each have their own
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise FileError(f"Expected a checkpoint in {path}, found a damaged file ({reason}); remove it") from error

    def train_step(self, progress: float) -> float:
        """One sequence, forward, backward, update; progress in 0..1 along the schedule. Returns the loss."""
        random = np.random.default_rng([self.config.seed, self.step])
        path = self.paths[random.integers(len(self.paths))]
        if path not in self.pairs:
            self.pairs[path] = Pair.read(path)
        pair = self.pairs[path]
        rate = min(1, (self.step + 1) / 200) * (0.02 + 0.98 * (1 + np.cos(np.pi * progress)) / 2)
        self.optimiser.param_groups[0]["lr"] = self.config.learning_rate * rate
        levels = pair.levels[: len(pair.levels) - int(random.random() < self.config.early)]
        loss = objective(pair, self.network(pair.V0, levels))
        self.optimiser.zero_grad()
        loss.backward()
        norm = torch.nn.utils.clip_grad_norm_(self.network.parameters(), self.config.gradient_norm)
        if torch.isfinite(norm):
            self.optimiser.step()
            self.losses.append(float(loss.detach()))
        decay = min(self.config.average, (self.step + 1) / (self.step + 10))
        with torch.no_grad():
            for a, p in zip(self.average.parameters(), self.network.parameters(), strict=True):
                a.lerp_(p, 1 - decay)
        self.step += 1
        return float(loss.detach())

    def checkpoint(self, seconds: float) -> dict:
        """Validate the moving average, append the row to the log, write checkpoint and weights. Returns the row."""
        row = {
            "step": self.step,
            "seconds": round(seconds),
            "loss": round(float(np.mean(self.losses or [np.nan])), 4),
            **{("val_loss" if k == "loss" else k): round(v, 4) for k, v in validate(self.average, self.val).items()},
        }
        self.losses = []
        state = {
            "step": np.int64(self.step),
            "seconds": np.float64(seconds),
            "config": np.array(json.dumps(asdict(self.config))),
        }
        for prefix, module in (("p:", self.network), ("a:", self.average)):
            state |= {prefix + k: v.numpy() for k, v in module.state_dict().items()}
        for name, value in self.network.named_parameters():
            moments = self.optimiser.state.get(value)
            for prefix, key in (("m:", "exp_avg"), ("v:", "exp_avg_sq")):
                state[prefix + name] = moments[key].numpy() if moments else np.zeros(tuple(value.shape), np.float32)
        save(self.out / "checkpoint.npz", state)
        save(self.out / "weights.npz", {k: v.numpy() for k, v in self.average.state_dict().items()})
        log = self.out / "log.csv"
        new = not log.exists()
        with log.open("a", newline="") as f:
            writer = csv.DictWriter(f, row.keys())
            if new:
                writer.writeheader()
            writer.writerow(row)
        return row

    def run(self) -> None:
        """Train until the hours of the schedule are used up, over resumed runs together."""
        begun, done = time.time() - self.seconds, False
        while not done:
            seconds = time.time() - begun
            progress = seconds / (self.config.hours * 3600)
            done = progress >= 1
            self.train_step(min(1.0, progress))
            if done or self.step % self.config.validate_every == 0:
                print(json.dumps(self.checkpoint(seconds)), flush=True)


def main() -> None:
    """Read the options, then train until the time is used up."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("sequences", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--hours", type=float, default=TrainConfig.hours, help="in all, over resumed runs")
    parser.add_argument("--rate", type=float, default=TrainConfig.learning_rate)
    parser.add_argument("--train", type=int, default=400, help="training sequences")
    parser.add_argument("--val", type=int, default=12, help="validation sequences")
    options = parser.parse_args()
    torch.set_num_threads(1)
    try:
        config = TrainConfig(hours=options.hours, learning_rate=options.rate)
        Trainer(options.sequences, options.out, config, options.train, options.val).run()
    except FileError as error:
        parser.error(str(error))


if __name__ == "__main__":
    main()
