"""Displaced subdivision surfaces: a base mesh, a subdivision scheme, and how far each vertex moves along its normal."""
from .displaced_surface import DisplacedSurface, SurfaceLevels
from .stencils import SMOOTHEST, Stencil, stencil_of

__all__ = ["DisplacedSurface", "SMOOTHEST", "Stencil", "SurfaceLevels", "stencil_of"]
