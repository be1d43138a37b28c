"""A small source and a surface near it."""
import numpy as np

from npm_blender.core.bitstream import around
from npm_blender.core.displacement import SMOOTHEST, DisplacedSurface
from npm_blender.core.fitting import DetailFit, Source, TwoWay
from npm_blender.core.mesh import TriMesh, UnitFrame
from tests.meshes.shapes import bumpy, grid, icosphere


def unit(mesh: TriMesh) -> TriMesh:
    """The mesh in the unit frame."""
    return TriMesh(UnitFrame.of(mesh.V).to_unit(mesh.V), mesh.F)


SHAPES = {"closed": (unit(bumpy(3)), unit(icosphere(1))), "open": (unit(grid(16)), unit(grid(4, 0.0)))}
SAMPLES = 6_000


def case(name: str, levels: int = 2, smooth: int = SMOOTHEST) -> tuple[Source, DisplacedSurface, np.ndarray]:
    """A source, a surface, and its base vertices, a first guess."""
    mesh, base = SHAPES[name]
    return Source(mesh, SAMPLES), DisplacedSurface(base.F, len(base.V), levels, smooth), base.V


def two_way(name: str, levels: int = 2, smooth: int = SMOOTHEST) -> tuple[TwoWay, np.ndarray]:
    """Their fit, and the base vertices."""
    source, surface, V0 = case(name, levels, smooth)
    return TwoWay(source, surface), V0


def detail_fit(name: str, levels: int = 2, smooth: int = SMOOTHEST) -> tuple[DetailFit, np.ndarray]:
    """As `two_way`, of the integers."""
    source, surface, V0 = case(name, levels, smooth)
    return DetailFit(source, surface, around(surface.hierarchy)), V0


def none(of) -> np.ndarray:
    """No moves of a surface."""
    return np.zeros(int(of.surface.first[-1]))
