"""The bijection that successive edge collapses define (SSP)."""
from .collapse_record import AT, FIRST, RING, S1, S2, SIDES, CollapseRecord
from .joint_flattening import flatten_jointly
from .stencil import ANCHORED, EDGE, INNER, MAX_RING
from .surface_map import SurfaceMap

__all__ = [
    "ANCHORED",
    "AT",
    "CollapseRecord",
    "EDGE",
    "FIRST",
    "INNER",
    "MAX_RING",
    "RING",
    "S1",
    "S2",
    "SIDES",
    "SurfaceMap",
    "flatten_jointly",
]
