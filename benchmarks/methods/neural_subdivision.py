"""Neural Subdivision (Liu et al. 2020) of QSlim's mesh: nothing but the base is sent, a network places the rest.

The network is the publication's, trained on the LoD sequences that ours was trained on (training/neural_subdivision).
"""

from functools import cache
from pathlib import Path

from npm_blender.core.mesh import TriMesh

from . import drc, qslim, schemes, search
from .case import Case, Coded

NAME = "Neural Subdivision"
WEIGHTS = Path(__file__).parents[2] / "training/runs/neural_subdivision/weights.npz"


@cache
def network():
    """The trained network. Raises FileError or WeightsError."""
    from training.neural_subdivision.network import read

    return read(WEIGHTS)


def subdivided(base: TriMesh) -> TriMesh:
    """The network's finest mesh over a base. Raises MeshError if it is not a manifold."""
    from training.neural_subdivision.network import subdivide

    return subdivide(network(), base, schemes.steps(len(base.F)))[-1]


def at_scalars(case: Case, counts: list[int]) -> list[TriMesh | None]:
    """QSlim's mesh of that many numbers, subdivided: with those of our base, 400 faces as published."""
    return [base and subdivided(base) for base in qslim.at_scalars(case, counts)]


def at_bytes(case: Case, budgets: tuple[int, ...]) -> list[Coded | None]:
    """The bases that QSlim + Draco chooses among, subdivided."""
    return search.choose(case, lambda data: subdivided(drc.decode(data)), drc.of_qslim(case, budgets))
