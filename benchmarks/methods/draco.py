"""Draco alone: the whole mesh, every vertex of it, at few or many bits."""

from npm_blender.core.errors import MeshError
from npm_blender.core.mesh import TriMesh

from . import drc
from .case import Case, Coded

NAME = "Draco"
BITS = tuple(range(4, 15))
SHOWN = (8, 10, 12, 14)  # bits of the rows that no budget asked for


def at_bytes(case: Case, budgets: tuple[int, ...]) -> list[Coded | None]:
    """The most bits that fit; None where the mesh has too many vertices for the budget."""
    coded = {bits: drc.encode(case.mesh, bits) for bits in BITS}
    out = []
    for budget in budgets:
        bits = max((b for b in BITS if len(coded[b]) <= budget), default=None)
        try:
            out.append(bits and Coded(drc.decode(coded[bits]), len(coded[bits]), f"{bits} bits"))
        except MeshError:  # rounded to nothing
            out.append(None)
    return out


def extra(case: Case) -> list[tuple[dict, TriMesh]]:
    """What the whole mesh takes at usual bits."""
    out = []
    for bits in SHOWN:
        data = drc.encode(case.mesh, bits)
        out.append(({"table": "whole", "at": bits, "bytes": len(data)}, drc.decode(data)))
    return out
