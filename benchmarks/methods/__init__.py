"""The methods of the comparison, one module each; every module exports NAME and what of these it can do:

    at_bytes(case, budgets) -> list[Coded | None]      the best mesh of at most so many bytes; None: none is so small
    at_scalars(case, counts) -> list[TriMesh | None]   the mesh that so many numbers buy (the paper's CR)
    extra(case) -> list[(dict, TriMesh)]                 further rows; the dict says of which table and what they are

A progressive method cuts one stream for all budgets; the others take the best setting for each, measured the worse
way: by the larger of d_pm and d_reverse.
"""

from importlib import import_module
from types import ModuleType

# in the order of the tables
METHODS = (
    "ours",
    "ours_sized",
    "ours_paper",
    "qslim_draco",
    "qslim",
    "fast_quadric",
    "loop",
    "butterfly",
    "subdivfit",
    "neural_subdivision",
    "progressive_meshes",
    "meshopt",
    "draco",
)
REFERENCE = "qslim_draco"  # what others are compared with in bytes
REFERENCE_SCALARS = "qslim"  # and in numbers


def load(name: str) -> ModuleType:
    """The module of a method. Raises ImportError, with the name of what is missing."""
    return import_module(f".{name}", __name__)
