"""Draco's bytes of a mesh, positions and connectivity, at its best compression level."""

import DracoPy
import numpy as np

from npm_blender.core.mesh import TriMesh

from . import search
from .case import Case

LEVEL = 10
BITS = tuple(range(8, 15))  # up to 12 usually; more for a mesh that fits a budget whole


def encode(mesh: TriMesh, bits: int) -> bytes:
    """The mesh, coordinates rounded to so many bits of its box; order of vertices and faces is free."""
    return DracoPy.encode(mesh.V, mesh.F, quantization_bits=bits, compression_level=LEVEL)


def decode(data: bytes) -> TriMesh:
    """The mesh of `encode`. Raises MeshError if nothing is left of it."""
    mesh = DracoPy.decode(data)
    return TriMesh.from_arrays(np.asarray(mesh.points), np.asarray(mesh.faces).reshape(-1, 3))


def of_qslim(case: Case, budgets: tuple[int, ...]) -> list[list[search.Candidate]]:
    """What of QSlim's meshes fits each budget: found once, for all methods that send such a mesh."""
    codec = search.Codec(case.qslim, len(case.mesh.F), encode, decode, BITS)
    return case.once(("drc", budgets), lambda: search.candidates(case, codec, budgets))
