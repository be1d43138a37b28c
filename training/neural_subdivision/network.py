"""Subdivision by a network (Liu, Kim, Chaudhuri, Aigerman, Jacobson: Neural Subdivision, SIGGRAPH 2020).

Three small perceptrons look at half-flaps (see `flaps`), the same ones at every level. *Initialisation* makes features
of the base from positions and differential coordinates; per level, *vertex* moves the vertices that are there, by the
mean over each ring, and *edge* places the new ones, by the mean of the two half-flaps, from the midpoint. Each gives 32
numbers: a displacement, which is turned back into the world, and 29 features that no motion changes.

Three things differ from the publication. Lengths are in units of the flap's mean edge length instead of the unit cube's
side, so that one network serves all levels and base sizes; border edges have flaps (the publication takes closed meshes
only); and no gradient goes through the frames.
"""

from pathlib import Path

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from npm_blender.core.errors import FileError, WeightsError
from npm_blender.core.mesh import TriMesh, hierarchy

from .flaps import Flaps, Frames, differential, edge_mean, local, ring_mean, turned

WIDTH = 32  # of the hidden layers, and numbers per vertex
FEATURES = WIDTH - 3


def perceptron(inputs: int) -> nn.Sequential:
    """Two hidden layers. The displacement starts at zero: an untrained network is midpoint subdivision."""
    last = nn.Linear(WIDTH, WIDTH)
    with torch.no_grad():
        last.weight[:3], last.bias[:3] = 0, 0
    return nn.Sequential(nn.Linear(inputs, WIDTH), nn.ReLU(), nn.Linear(WIDTH, WIDTH), nn.ReLU(), last)


class NeuralSubdivision(nn.Module):
    """The network of three modules."""

    def __init__(self) -> None:
        super().__init__()
        self.initialisation = perceptron(9 + 4 * 3)
        self.vertex = perceptron(9 + 4 * FEATURES)
        self.edge = perceptron(9 + 4 * FEATURES)

    def forward(self, V0: torch.Tensor, levels: list[Flaps]) -> list[torch.Tensor]:
        """Positions of levels 0..L, (n_l, 3) each, from those of the base V0 (n_0, 3); levels: flaps of levels 0..L-1."""
        frames = _frames(V0, levels[0])
        vectors = differential(V0, levels[0])
        moves, features = _apply(self.initialisation, frames, _turned_corners(vectors, levels[0], frames))
        V, H = V0 + ring_mean(moves, levels[0]), ring_mean(features, levels[0])
        positions = [V]
        for flaps in levels:
            frames = _frames(V, flaps)
            moves, features = _apply(self.vertex, frames, _corners(H, flaps))
            V, H = V + ring_mean(moves, flaps), ring_mean(features, flaps)
            frames = _frames(V, flaps)
            moves, features = _apply(self.edge, frames, _corners(H, flaps))
            V = torch.cat([V, (V[flaps.a] + V[flaps.b]) / 2 + edge_mean(moves)])
            H = torch.cat([H, edge_mean(features)])
            positions.append(V)
        return positions


def _frames(V: torch.Tensor, flaps: Flaps) -> Frames:
    """The frames over V, taken as they are: every level has a loss of its own, and a step costs a quarter less."""
    with torch.no_grad():
        return Frames.of(V, flaps)


def _apply(module: nn.Module, frames: Frames, corners: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Displacements in the world (2 e, 3) and features (2 e, 29) of all half-flaps; corners (2 e, C): what they know."""
    first = module[0]  # in two parts: joining the inputs would copy the larger one
    x = functional.linear(corners, first.weight[:, 9:]) + functional.linear(frames.corners, first.weight[:, :9], first.bias)
    y = module[1:](x)
    return frames.world(y[:, :3]), y[:, 3:]


def _corners(H: torch.Tensor, flaps: Flaps) -> torch.Tensor:
    """Features (2 e, 4 C) of the four corners of each half-flap, of H (n, C)."""
    return H.index_select(0, flaps.corners).reshape(len(flaps.first), -1)


def _turned_corners(P: torch.Tensor, flaps: Flaps, frames: Frames) -> torch.Tensor:
    """Vectors P (n, 3) at the four corners of each half-flap, in its frame and unit, (2 e, 12)."""
    a, b, c, d = (local(frames.x, frames.y, frames.z, P[i] / frames.unit) for i in (flaps.a, flaps.b, flaps.c, flaps.d))
    return torch.cat([torch.cat([a, b, c, d], 1), torch.cat([turned(p) for p in (b, a, d, c)], 1)])


def subdivide(network: NeuralSubdivision, base: TriMesh, levels: int = 3) -> list[TriMesh]:
    """The meshes of levels 0..levels that the network makes of a base mesh. Raises MeshError if it is not a manifold."""
    lods = hierarchy(base.F, len(base.V), levels)
    with torch.no_grad():
        # about its centre, where single precision is finest
        centre = base.V.mean(0)
        V = network(torch.from_numpy((base.V - centre).astype(np.float32)), [Flaps.of(level) for level in lods[:-1]])
    return [TriMesh(v.numpy().astype(np.float64) + centre, level.F) for v, level in zip(V, lods, strict=True)]


def read(path: Path) -> NeuralSubdivision:
    """The network of a file of `training.neural_subdivision.train`. Raises FileError, or WeightsError if it is damaged."""
    if not path.is_file():
        raise FileError(f"Expected trained weights at {path}, found none; docs/training.md says how they are made")
    network = NeuralSubdivision()
    try:
        with np.load(path, allow_pickle=False) as z:
            network.load_state_dict({k: torch.from_numpy(z[k]) for k in z.files})
    except Exception as error:  # zip, NumPy and torch each have their own
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise WeightsError(f"Expected readable weights in {path}, found a damaged file ({reason}); train again") from error
    return network.eval()
