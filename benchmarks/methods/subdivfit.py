"""A control mesh fitted so that its Loop subdivision lies nearest to the input.

Points of the limit surface are linear in the control vertices. They are drawn to their closest points on the input,
again and again: least squares whose matrix stays the same, factored once (Hoppe et al. 1994, without their creases).
"""

from collections.abc import Callable

import numpy as np
from scipy.sparse import csr_matrix, diags, identity
from scipy.sparse.linalg import splu

from npm_blender.core.geometry import ClosestPoints
from npm_blender.core.mesh import Level, TriMesh, midpoints

from . import drc, qslim, schemes, search
from .case import Case, Coded

NAME = "SubdivFit"
ITERATIONS, MOMENTUM = 12, 0.9  # without momentum three times as many iterations give the same
SPRING = 1e-3  # pull to the last positions, relative to the pull of the points
SMALL = 1_700  # faces of a control mesh whose limit surface is drawn by 16 points for each control vertex, not by 4


def depth(mesh: TriMesh) -> int:
    """Subdivisions of a control mesh that give the points."""
    return 2 if len(mesh.F) <= SMALL else 1


def limit_points(mesh: TriMesh) -> tuple[csr_matrix, np.ndarray]:
    """Points of the limit surface as a matrix (k, n) over the control vertices, and the faces (m, 3) between them."""
    level = Level.of(mesh.F, len(mesh.V))
    A = identity(len(mesh.V), format="csr")
    for _ in range(depth(mesh)):
        A, level = schemes.loop(level) @ A, level.subdivided()
    return schemes.loop_limit(level) @ A, level.F


def fit(mesh: TriMesh, surface: ClosestPoints) -> TriMesh:
    """The control mesh `mesh` moved. surface: the input. Raises MeshError if the mesh is no oriented manifold."""
    A, F = limit_points(mesh)
    V = mesh.V
    points = TriMesh(_piecewise(mesh), F)  # the first solution's limit is the mesh itself, as far as least squares go
    area = np.bincount(F.reshape(-1), np.repeat(points.face_areas(), 3), len(points.V))
    W = diags(area / area.sum())
    M = (A.T @ W @ A).tocsc()
    spring = SPRING * M.diagonal().mean()
    solve = splu((M + spring * identity(len(V))).tocsc()).solve
    target, last = points.V, None
    for _ in range(ITERATIONS):
        new = solve(A.T @ (W @ target) + spring * V)
        V = new if last is None else new + MOMENTUM * (new - last)
        last, target = new, surface.closest(A @ V)[1]
    return TriMesh(solve(A.T @ (W @ target) + spring * V), mesh.F)


def _piecewise(mesh: TriMesh) -> np.ndarray:
    """Where the points start: midpoint subdivision."""
    V, level = mesh.V, Level.of(mesh.F, len(mesh.V))
    for _ in range(depth(mesh)):
        V, level = midpoints(V, level), level.subdivided()
    return V


def control(case: Case, faces: int) -> TriMesh:
    """QSlim's mesh of so many faces, fitted."""
    surface = case.once("surface", lambda: ClosestPoints(case.mesh))
    slim = case.qslim(faces)
    return case.once(("subdivfit", len(slim.F)), lambda: fit(slim, surface))


def at_scalars(case: Case, counts: list[int]) -> list[TriMesh | None]:
    """The fitted control mesh of that many numbers, subdivided."""
    slim = qslim.at_scalars(case, counts)
    return [mesh and schemes.subdivided(control(case, len(mesh.F)), schemes.loop) for mesh in slim]


def at_bytes(case: Case, budgets: tuple[int, ...]) -> list[Coded | None]:
    """The fitted control mesh by Draco, near the settings that are best for QSlim + Draco."""
    codec = search.Codec(lambda n: control(case, n), len(case.mesh.F), drc.encode, drc.decode, drc.BITS)
    decode = lambda data: schemes.subdivided(drc.decode(data), schemes.loop)
    return [_coded(case, codec, decode, budget, some) for budget, some in zip(budgets, drc.of_qslim(case, budgets), strict=True)]


def _coded(case: Case, codec: search.Codec, decode: Callable, budget: int, near: list[search.Candidate]) -> Coded | None:
    """The first of the settings that gives a surface: where rounding merges vertices, it may not be one any more."""
    for setting in near:
        found = search.fitted(codec, setting.faces, setting.bits, budget)
        coded = search.choose(case, decode, [[found] if found else []])[0]
        if coded:
            return coded
    return None
