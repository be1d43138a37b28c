"""The subdivision codec without a network at its best: for each budget the base size and the steps that suit it.

Numbers (at_scalars) are counted as for our own codec: three per base vertex, and one per integer that is not zero.
"""

from dataclasses import replace

import numpy as np

from benchmarks.subdivision import search, stream
from benchmarks.subdivision.fit import Target
from npm_blender.core.mesh import TriMesh

from .case import Case, Coded

NAME = "Subdivision codec"
FIRST = (400, 3, 9)
# base faces, levels, bits of a base coordinate; first step; least and most bytes that the base is tried for
BASES = ((FIRST, 116, 0, 2_100), ((800, 3, 9), 132, 1_200, 6_000), ((1600, 3, 10), 148, 3_000, 33_000))
PASSES = 2
SPARSE_STEP, SPARSE = 208, (64.0, 16.0, 4.0, 1.0, 0.25, 0.06)  # fine steps; prices of a bit that leave few integers


def target(case: Case) -> Target:
    """The input's closest points, made once."""
    return case.once("subdivision target", lambda: Target(case.mesh))


def base(case: Case, *size: int) -> search.Base:
    """The fitted base of (faces, levels, bits), made once; all sizes under the scheme that suits 400 faces."""

    def make() -> search.Base:
        smooth = search.SMOOTH if size == FIRST else (base(case, *FIRST).smooth,)
        return search.fitted(case.mesh, target(case), *size, smooth)

    return case.once(("subdivision base", size), make)


def at_bytes(case: Case, budgets: tuple[int, ...]) -> list[Coded | None]:
    """For each budget the base that promises the least error the worse way, with steps that fill the budget."""
    tried = []
    for size, step, least, most in BASES:
        if not any(least <= b <= most for b in budgets) or size[0] > len(case.mesh.F):
            continue
        b = base(case, *size)
        most = min(most, max(budgets))
        points = search.sweep(b, step, most, PASSES)
        tried.append((b, [replace(p, distance=case.worse(stream.read(p.data))) for p in points], size[0]))
    out: list[Coded | None] = []
    for budget in budgets:
        order = sorted(tried, key=lambda t: search.expected(t[1], budget))
        found = search.between(order[0][0], order[0][1], budget, PASSES) if order else None
        if found is None:
            out.append(None)
            continue
        label = f"{order[0][2]} faces, step {2.0 ** (-found.step / stream.STEP_UNIT):.5f}"
        out.append(Coded(stream.read(found.data), len(found.data), label))
    return out


def at_scalars(case: Case, counts: list[int]) -> list[TriMesh | None]:
    """400 base faces and the integers that a price leaves, the lowest price whose numbers suffice."""
    b = base(case, *FIRST)
    points: list[search.Point] = []
    for trade in SPARSE:
        points.append(search.point(b, SPARSE_STEP, points[-1] if points else None, 2, trade))
        if 3 * len(b.ints) + np.count_nonzero(points[-1].value) > max(counts):
            break
    out: list[TriMesh | None] = []
    for count in counts:
        fits = [p for p in points if 3 * len(b.ints) + np.count_nonzero(p.value) <= count]
        out.append(stream.read(fits[-1].data) if fits else None)
    return out
