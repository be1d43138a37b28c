"""Modified Butterfly subdivision of QSlim's base."""

from npm_blender.core.mesh import TriMesh

from . import drc, qslim, schemes, search
from .case import Case, Coded

NAME = "Butterfly"


def at_scalars(case: Case, counts: list[int]) -> list[TriMesh | None]:
    """QSlim's mesh of that many numbers, subdivided."""
    slim = qslim.at_scalars(case, counts)
    return [mesh and schemes.subdivided(mesh, schemes.butterfly) for mesh in slim]


def at_bytes(case: Case, budgets: tuple[int, ...]) -> list[Coded | None]:
    """The bases that QSlim + Draco chooses among, subdivided."""
    decode = lambda data: schemes.subdivided(drc.decode(data), schemes.butterfly)
    return search.choose(case, decode, drc.of_qslim(case, budgets))
