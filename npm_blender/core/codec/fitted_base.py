"""The base of a displaced surface: decimated, fitted to the source both ways under the scheme that suits it, rounded."""
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..bitstream import EncodedBase, encode_base, order_connectivity
from ..decimation import decimate
from ..displacement import SMOOTHEST, DisplacedSurface
from ..fitting import Rounding, TwoWay, fit_base, sharp_of
from ..mesh import Level, Sharp, TriMesh
from ..progress import Progress, no_progress, part
from ..settings import AUTO
from .target import Target


class Scheme(NamedTuple):
    """smooth: see `DisplacedSurface`; angle: degrees from which an edge of the base is a crease, 0 for none."""

    smooth: int
    angle: float = 0.0

    def sharp(self, V0: np.ndarray, base: Level) -> Sharp | None:
        """Creases and corners of a base with vertices V0 (n0, 3)."""
        return sharp_of(V0, base, self.angle) if self.angle else None


SCHEMES = (Scheme(0), Scheme(SMOOTHEST // 2), Scheme(SMOOTHEST), Scheme(SMOOTHEST, 60), Scheme(SMOOTHEST, 40),
           Scheme(SMOOTHEST, 25))
TRIED_LEVELS, FITTED_LEVELS = 2, 3  # at which schemes are compared, and the base of the best is fitted
TRIAL_PASSES, PASSES = 2, 3     # of a fit, while schemes are compared and after
MANY = 3000                     # faces of a base that is fitted at fewer levels
FINEST, FINER = 260_000, 12     # faces of the finest level at most, in all and over those of the source
LEAST_BITS, MOST_BITS = 7, 20   # of a coordinate of the base
CREASED = 1.1                   # creases have to leave so much less than none: their bytes, and details do not cross them
RATE = 0.8                      # a base of twice the bytes has to leave 2 ** -RATE of the error
AREA = 0.05                     # of its area, that a base may win or lose when it is rounded
ROUNDED = 1.1                   # the error of a rounded base over that of the free one, which ends the search for bits
LEAST_ERROR = 2e-6              # nobody sees less
PLAIN = -1                      # levels of a base that gets none


@dataclass(frozen=True)
class FittedBase:
    """A base under a scheme. surface: of all levels; grid (n0, 3) int64: lattice positions; bits: of a coordinate; coded: as
    bytes; error: of the surface without details, the worse way, unit frame; scheme: that of the surface."""

    surface: DisplacedSurface
    grid: np.ndarray
    bits: int
    coded: EncodedBase
    error: float
    scheme: Scheme

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
                 schemes: tuple[Scheme, ...] = SCHEMES) -> None:
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
        schemes = schemes if self.levels else SCHEMES[:1]
        base, tried = Level.of(self._F0, self._n0), min(self.levels, TRIED_LEVELS)
        found = {scheme: self._fitted(V0, DisplacedSurface(self._F0, self._n0, tried, scheme.smooth, scheme.sharp(V0, base)),
                                      0 if len(schemes) == 1 or (whole and not scheme.smooth) else TRIAL_PASSES)
                 for scheme in schemes}
        self.scheme = min(found, key=lambda scheme: found[scheme][0] * (CREASED if scheme.angle else 1))
        self.error, self._fit, V0 = found[self.scheme]
        self.surface = replace(self._fit.surface, levels=self.levels)
        progress(0.6, "Fitting the base")
        if not (whole and not self.surface.smooth):
            fitted = FITTED_LEVELS if self.levels >= FITTED_LEVELS and len(order.F) < MANY else self._fit.surface.levels
            self.error, self._fit, V0 = self._fitted(V0, self.surface.with_levels(fitted), PASSES)
        progress(0.9, "Fitting the base")
        self._rounding = Rounding(self._fit, V0, np.zeros(int(self._fit.surface.first[-1])))

    def _fitted(self, V0: np.ndarray, surface: DisplacedSurface, passes: int) -> tuple[float, TwoWay, np.ndarray]:
        """The error, the fit and the base vertices (n0, 3) from V0 on."""
        fit = TwoWay(self.target.source, surface)
        none = np.zeros(int(surface.first[-1]))
        V0 = fit_base(fit, V0, none, passes)
        return self.target.error(surface, V0, none), fit, V0

    def rounded(self, bits: int) -> FittedBase:
        """The base on a lattice; bits: of a coordinate, AUTO for as many as pay: error times bytes is least, the area stays."""
        best, least = None, np.inf
        for tried in range(bits or LEAST_BITS, (bits or MOST_BITS) + 1):
            found, area = self._on_lattice(tried)
            if abs(area - 1) > AREA and tried < (bits or MOST_BITS):
                continue
            cost = max(found.error, LEAST_ERROR) * (len(found.coded.connectivity) + len(found.coded.positions)) ** RATE
            if cost < least:
                best, least = found, cost
            if found.error < ROUNDED * max(self.error, LEAST_ERROR):  # finer steps have nothing to give
                break
        assert best
        return best

    def _on_lattice(self, bits: int) -> tuple[FittedBase, float]:
        """The base with so many bits, and its area over that of the free one."""
        grid = self._rounding.on_lattice(2.0**-bits)
        V0, F0 = grid * 2.0**-bits, self._F0
        error = self.target.error(self._fit.surface, V0, np.zeros(int(self._fit.surface.first[-1])))
        coded = encode_base(grid, F0, self._connectivity, self.surface.sharp)
        area = TriMesh(V0, F0).face_areas().sum() / max(TriMesh(self._rounding.V0, F0).face_areas().sum(), 1e-300)
        return FittedBase(self.surface, grid, bits, coded, error, self.scheme), area
