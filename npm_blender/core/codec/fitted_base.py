"""The base of a displaced surface: decimated, fitted to the source both ways under the scheme that suits it, rounded."""
from dataclasses import dataclass

import numpy as np

from ..bitstream import EncodedBase, encode_base, order_connectivity
from ..decimation import decimate
from ..displacement import SMOOTHEST, DisplacedSurface
from ..fitting import Rounding, TwoWay, fit_base
from ..progress import Progress, no_progress, part
from ..settings import AUTO
from .target import Target

SCHEMES = (0, SMOOTHEST // 2, SMOOTHEST)
TRIED_LEVELS, FITTED_LEVELS = 2, 3  # at which schemes are compared, and the base of the best is fitted
TRIAL_PASSES, PASSES = 2, 3     # of a fit, while schemes are compared and after
MANY = 3000                     # faces of a base that is fitted at fewer levels
FINEST, FINER = 260_000, 12     # faces of the finest level at most, in all and over those of the source
LEAST_BITS, MOST_BITS = 7, 20   # of a coordinate of the base
ROUNDED = 1.1                   # the error of a rounded base over that of the free one
LEAST_ERROR = 2e-6              # nobody sees less
PLAIN = -1                      # levels of a base that gets none


@dataclass(frozen=True)
class FittedBase:
    """A base under a scheme. surface: of all levels; grid (n0, 3) int64: lattice positions; bits: of a coordinate; coded: as
    bytes; error: of the surface without details, the worse way, unit frame."""

    surface: DisplacedSurface
    grid: np.ndarray
    bits: int
    coded: EncodedBase
    error: float

    @property
    def V0(self) -> np.ndarray:
        """Base positions (n0, 3) as the receiver has them."""
        return self.grid * 2.0**-self.bits


def levels_for(faces: int, source_faces: int, most: int = 4) -> int:
    """Levels over a base of so many faces: up to `most`, as long as the finest is not much finer than the source."""
    count = most
    while count > 1 and (faces * 4**count > max(FINER * source_faces, 20_000) or faces * 4**count > FINEST):
        count -= 1
    return count


class FreeBase:
    """A base that is fitted to a target, under that of the schemes whose surface without details is nearest."""

    def __init__(self, target: Target, faces: int, levels: int, progress: Progress = no_progress, room: bool = True,
                 schemes: tuple[int, ...] = SCHEMES) -> None:
        """faces: about so many; levels: AUTO for as many as suit them, PLAIN for none; room: as in `decimate`.

        Raises MeshError where the mesh cannot be decimated, Cancelled from `progress`.
        """
        self.target = target
        decimation = decimate(target.mesh, faces, 0, part(progress, 0, 0.2), room)
        self.message = decimation.message
        order, self._connectivity = order_connectivity(decimation.F0, len(decimation.V0))
        self._F0, self._n0, V0 = order.F, len(decimation.V0), decimation.V0[order.vertices]
        whole = len(order.F) == len(target.mesh.F)
        if levels == AUTO:  # the source itself has nothing to gain from levels
            levels = PLAIN if whole else levels_for(len(order.F), len(target.mesh.F))
        self.levels = max(levels, 0)
        progress(0.2, "Fitting the base")
        tried = [self._fitted(V0, smooth, min(self.levels, TRIED_LEVELS), 0 if whole and not smooth else TRIAL_PASSES)
                 for smooth in (schemes if self.levels else SCHEMES[:1])]
        self.error, self._fit, V0 = min(tried, key=lambda one: one[0])
        progress(0.6, "Fitting the base")
        if not (whole and not self.smooth):
            fitted = FITTED_LEVELS if self.levels >= FITTED_LEVELS and len(order.F) < MANY else self._fit.surface.levels
            self.error, self._fit, V0 = self._fitted(V0, self.smooth, fitted, PASSES)
        progress(0.9, "Fitting the base")
        self._rounding = Rounding(self._fit, V0, np.zeros(int(self._fit.surface.first[-1])))

    @property
    def smooth(self) -> int:
        """Of the scheme."""
        return self._fit.surface.smooth

    def _fitted(self, V0: np.ndarray, smooth: int, levels: int, passes: int) -> tuple[float, TwoWay, np.ndarray]:
        """The error, the fit and the base vertices (n0, 3) from V0 on, measured at so many levels."""
        fit = TwoWay(self.target.source, DisplacedSurface(self._F0, self._n0, levels, smooth))
        none = np.zeros(int(fit.surface.first[-1]))
        V0 = fit_base(fit, V0, none, passes)
        return self.target.error(fit.surface, V0, none), fit, V0

    def rounded(self, bits: int) -> FittedBase:
        """The base on a lattice; bits: of a coordinate, AUTO for as many as its error asks for."""
        none = np.zeros(int(self._fit.surface.first[-1]))
        for tried in range(bits or LEAST_BITS, (bits or MOST_BITS) + 1):
            grid = self._rounding.on_lattice(2.0**-tried)
            error = self.target.error(self._fit.surface, grid * 2.0**-tried, none)
            if error <= ROUNDED * max(self.error, LEAST_ERROR):
                break
        surface = DisplacedSurface(self._F0, self._n0, self.levels, self.smooth)
        return FittedBase(surface, grid, tried, encode_base(grid, self._F0, self._connectivity), error)
