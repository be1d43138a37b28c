"""The methods of the comparison, one module each; every module exports NAME and what of these it can do:

    at_bytes(case, budgets) -> list[Coded | None]      the best mesh of at most so many bytes; None: none is so small
    at_scalars(case, counts) -> list[TriMesh | None]     the mesh that so many numbers buy (the paper's CR)

A progressive method cuts one stream for all budgets; the others take the best setting for each, measured by d_pm.
"""
