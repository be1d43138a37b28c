"""What is sent of a mesh: base vertices and integers of a displaced surface, fitted to the source in both directions."""
from .base_fit import Rounding, fit_base
from .detail_fit import DetailFit, StageFit
from .rates import default_rate
from .sharp_edges import sharp_of
from .source import Source
from .two_way import TwoWay

__all__ = ["DetailFit", "Rounding", "Source", "StageFit", "TwoWay", "default_rate", "fit_base", "sharp_of"]
