"""The triangles in the plane of a collapse in the record, before and after it, and which of their sides are on the border."""
from typing import NamedTuple

import numpy as np

from ..jit import compiled
from .collapse_record import AT, FIRST, J_START, J_STOP, RING, SIDES
from .stencil import is_of_j, next_on_ring, third_vertex


class RecordedStencil(NamedTuple):
    """A stencil of the record: ring_size, sides, j_start and j_stop as in `Stencil`; at: where its positions begin in uv;
    face_count: number of its faces before the collapse, those of the sides and those that vanish."""

    at: int
    ring_size: int
    sides: int
    j_start: int
    j_stop: int
    face_count: int


@compiled(inline="always")
def recorded_stencil(record, c):
    """The stencil of collapse c."""
    row = record.collapses[c]
    return RecordedStencil(np.int64(row[AT]), np.int64(row[RING]), np.int64(row[SIDES]), np.int64(row[J_START]),
                           np.int64(row[J_STOP]), np.int64(record.collapses[c + 1, FIRST] - record.collapses[c, FIRST]))


@compiled(inline="always")
def triangle_corners(stencil, q, before):
    """Indices into uv of the corners (owner, next, next) of face number q of a stencil, before or after the collapse."""
    i = stencil.at + stencil.ring_size
    if q < stencil.sides:
        owner = i + 2
        if before:
            owner = i + 1 if is_of_j(stencil, q) else i
        return owner, stencil.at + q, stencil.at + next_on_ring(stencil, q)
    if q == stencil.sides:
        return i, i + 1, stencil.at + third_vertex(stencil)
    return i + 1, i, stencil.at + stencil.j_start


@compiled
def is_on_border(stencil, q, before, corner):
    """Whether the side opposite to a corner (0: owner) of face number q of a stencil is on the mesh's border."""
    ring_size, sides, j_start, j_stop = stencil.ring_size, stencil.sides, stencil.j_start, stencil.j_stop
    if ring_size == sides:
        return False
    anchored = stencil.face_count == sides + 2
    if q < sides:
        if corner == 2 and q == 0:
            return not before or (j_start > 0 if anchored else j_stop > 0)
        return corner == 1 and q == sides - 1 and (not before or j_stop < ring_size - 1)
    if q == sides:
        if corner == 1:
            return j_stop == ring_size - 1
        return not anchored and (corner == 2 or j_stop == 0)
    return corner == 0 and j_start == 0


@compiled(inline="always")
def face_count(stencil, before):
    """Number of faces of a stencil, before or after the collapse."""
    return stencil.face_count if before else stencil.sides
