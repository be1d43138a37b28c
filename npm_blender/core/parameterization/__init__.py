"""The bijection that successive edge collapses define (SSP)."""
from .collapse_record import (
    AT,
    COLLAPSES,
    FACES,
    FIRST,
    J_START,
    J_STOP,
    POSITIONS,
    RING,
    SIDES,
    CollapseRecord,
)
from .joint_flattening import flatten_jointly
from .stencil import ANCHORED, EDGE, INNER, MAX_RING, SPARE, Stencil, Workspace, is_of_j, next_on_ring
from .surface_map import SurfaceMap

__all__ = [
    "ANCHORED",
    "AT",
    "COLLAPSES",
    "CollapseRecord",
    "EDGE",
    "FACES",
    "FIRST",
    "INNER",
    "J_START",
    "J_STOP",
    "MAX_RING",
    "POSITIONS",
    "RING",
    "SIDES",
    "SPARE",
    "Stencil",
    "SurfaceMap",
    "Workspace",
    "flatten_jointly",
    "is_of_j",
    "next_on_ring",
]
